/* page: what of the page the viewer reads and writes. */
const planishPage = (function () {
'use strict';

const section = document.getElementById('picture');

/** The only element of a class in the picture, or null. */
function part(name) {
    return section.querySelector('.' + name);
}

/** A style sheet's variable as a colour. */
function themeColour(name) {
    return new THREE.Color(getComputedStyle(section).getPropertyValue(name).trim());
}

/** A whole number as the page has it. */
function countOf(n) {
    return n.toLocaleString('en').replaceAll(',', '\u202f');
}

function plural(n, noun) {
    return countOf(n) + ' ' + noun + (n === 1 ? '' : 's');
}

/** A ratio as the page has it. */
function textOf(value) {
    return value >= 9999.5 && value < 1e7 ? countOf(Math.round(value))
        : value < Infinity ? value.toPrecision(4) : 'any';
}

return {section, part, themeColour, countOf, plural, textOf};
})();
