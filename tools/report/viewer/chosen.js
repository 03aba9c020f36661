/* chosen: what is chosen to be shown, and which elements that is. */
const planishChosen = (function () {
'use strict';

const {picture, states} = planishData, {part} = planishPage;
const slider = part('worse');

/* The measure that colours elements; the bins of a histogram, or null; the axis and place (0 to 1) of
 * the cut, or null; the share of the view that is the first state's. */
const chosen = {measure: 0, brush: null, cut: null, divider: 0.5, apart: false};

/** The range of ratios for which all worse elements are known, in every state: empty, from
 *  infinity, where there are more inverted ones than are drawn in all of them. */
function findRange() {
    let low = 1, high = 1, anyFinite = false;
    for (const state of states) {
        const ratios = state.bad.ratios, n = ratios.length, last = n ? ratios[n - 1] : 1;
        if (n < picture.elements && last > 0)
            low = Math.max(low, last);
        anyFinite = anyFinite || n === 0 || last > 0;
        for (const ratio of ratios)
            high = Math.max(high, ratio);
    }
    return anyFinite ? [low, Math.max(high, low)] : [Infinity, Infinity];
}

const [lowest, highest] = findRange();

function limit() {
    return highest > lowest ? lowest * Math.pow(highest / lowest, slider.value / slider.max) : lowest;
}

/** Whether the code of an element, for the measure of the histogram, is in the chosen bins. */
function isBrushed(code) {
    return code >= chosen.brush.codes[0] && code <= chosen.brush.codes[1];
}

/** How many bad elements are worse than value, inverted ones always. */
function countWorse(state, value) {
    const ratios = state.bad.ratios;
    let n = 0;
    while (n < ratios.length && !(ratios[n] > 0 && ratios[n] <= value))
        n++;
    return n;
}

return {chosen, slider, lowest, highest, limit, isBrushed, countWorse};
})();
