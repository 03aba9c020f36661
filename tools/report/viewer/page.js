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

function plural(n, noun) {
    return n.toLocaleString('en') + ' ' + noun + (n === 1 ? '' : 's');
}

function textOf(value) {
    return value < 1000 ? value.toPrecision(3)
        : value < 1e7 ? Math.round(value).toLocaleString('en')
        : value < Infinity ? value.toPrecision(3) : 'any';
}

return {section, part, themeColour, plural, textOf};
})();
