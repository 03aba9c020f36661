/* histograms: choose elements by the bins of a histogram. */
const planishHistograms = (function () {
'use strict';

const {states, measures} = planishData, {chosen} = planishChosen, {update} = planishContent;
const brushes = [];

/** Choose the bins from and to of a histogram, or none. */
function brush(histogram, from, to) {
    const measure = measures[histogram.measure];
    chosen.brush = from === null ? null : {
        measure: histogram.measure, from: from, to: to + 1, bins: histogram.bins,
        codes: measure.range(from, to + 1 < histogram.bins ? to + 1 : measure.bins),
        counts: states.map((_, s) => histogram.counts[s].slice(from, to + 1).reduce((a, b) => a + b, 0))
    };
    for (const other of brushes)
        showBrush(other, other === histogram ? from : null, to);
    update();
}

/** Mark the chosen bins of a histogram, and say which they are. */
function showBrush(histogram, from, to) {
    const {frame, mark, bins} = histogram, step = (frame[1] - frame[0]) / bins;
    histogram.from.value = from === null ? '' : from;
    histogram.to.value = from === null ? '' : to;
    histogram.to.disabled = histogram.clear.disabled = from === null;
    mark.setAttribute('x', frame[0] + step * (from || 0));
    mark.setAttribute('width', from === null ? 0 : step * (to + 1 - from));
}

/** Choose bins by dragging over the drawing. */
function connectDrag(histogram) {
    const {svg, frame, bins} = histogram;
    let first = null;
    const binAt = event => {
        const box = svg.getBoundingClientRect(), x = (event.clientX - box.left) / box.width;
        const bin = (x * svg.viewBox.baseVal.width - frame[0]) / (frame[1] - frame[0]) * bins;
        return Math.max(0, Math.min(bins - 1, Math.floor(bin)));
    };
    const move = event => {
        const bin = binAt(event);
        if (first !== null)
            brush(histogram, Math.min(first, bin), Math.max(first, bin));
    };
    svg.addEventListener('pointerdown', event => {
        if (event.button !== 0)
            return;
        first = binAt(event);
        event.preventDefault();
        move(event);
    });
    window.addEventListener('pointermove', move);
    for (const end of ['pointerup', 'pointercancel'])
        window.addEventListener(end, () => { first = null; });
}

/** Choose bins by lists, which keys reach. */
function connectLists(histogram) {
    const {from, to, clear, bins} = histogram, {edges, unit} = measures[histogram.measure];
    from.append(new Option('all', ''));
    for (let i = 0; i < bins; i++) {
        from.append(new Option(edges[i] + unit, i));
        to.append(new Option(i + 1 === bins && edges[i + 1] === null ? 'any'
            : edges[i + 1] + unit, i));
    }
    const change = () => {
        const first = from.value === '' ? null : Number(from.value);
        const last = to.value === '' ? bins - 1 : Math.max(first, Number(to.value));
        brush(histogram, first, last);
    };
    from.addEventListener('change', change);
    to.addEventListener('change', change);
    clear.addEventListener('click', () => { brush(histogram, null, 0); from.focus(); });
}

function connectHistograms() {
    for (const figure of document.querySelectorAll('figure[data-measure]')) {
        const measure = measures.findIndex(of => of.key === figure.dataset.measure);
        if (measure < 0)
            continue;
        const svg = figure.querySelector('svg'), [from, to] = figure.querySelectorAll('select');
        const counts = figure.dataset.counts.split(';').map(list => list.split(',').map(Number));
        const histogram = {measure: measure, svg: svg, from: from, to: to, counts: counts,
            clear: figure.querySelector('button'), mark: svg.querySelector('.mark'),
            frame: figure.dataset.frame.split(',').map(Number), bins: counts[0].length};
        brushes.push(histogram);
        connectLists(histogram);
        connectDrag(histogram);
        showBrush(histogram, null, 0);
        svg.classList.add('brushable');
        for (const hidden of figure.querySelectorAll('.brush'))
            hidden.hidden = false;
    }
}

return {connectHistograms};
})();
