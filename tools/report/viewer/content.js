/* content: what is chosen, drawn in the view and said in its captions. */
const planishContent = (function () {
'use strict';

const {picture, dim, isFlat, isComplete, measures, COLOURS, INVERTED} = planishData;
const {part, themeColour, countOf, plural, textOf} = planishPage;
const {chosen, slider, lowest, highest, limit, countWorse} = planishChosen;
const {paintFacets} = planishShape, {makeDots, addElements, brushed} = planishElements;
const {crossing, addSquares, clip} = planishCut, {holder, layers, drawSoon} = planishView;

/** What is shown of the elements of a histogram's bins, which has the states before and after alone; drawn: how
 *  many of them are. */
function describeBrush(state, i, drawn) {
    const brush = chosen.brush, measure = measures[brush.measure];
    const to = measure.edges[brush.to], n = brush.counts[i];
    const range = measure.name + ' ' + measure.edges[brush.from] + measure.unit +
        (to === null ? ' and more' : ' to ' + to + measure.unit);
    const text = plural(n, 'element') + ', ' + range;
    return state.sweep ? 'elements, ' + range : isFlat || drawn >= n ? text : text + '; ' + countOf(drawn) + ' of them are drawn';
}

/** What a view shows, in words. */
function describe(state, value, text) {
    const drawn = countWorse(state, Infinity), n = countWorse(state, value);
    if (value === Infinity || drawn < state.inverted) // more than are drawn, whatever the value
        return plural(state.inverted, 'inverted element') +
            (drawn < state.inverted ? ', of which ' + countOf(drawn) + ' are drawn' : '');
    const isCut = state.sweep && n === state.bad.n && n < picture.elements; // others are not known
    return (isCut ? 'at least ' : '') + plural(n, 'element') + ' worse than ' + text +
        (drawn ? ', ' + countOf(drawn) + ' of them inverted' : '');
}

/** Of flat elements that overlap, the one that is drawn last is seen: the worst, unless elements wrap around the
 *  whole mesh. */
function worstLast(list) {
    return 'wraps' in holder.dataset ? list : list.slice().reverse();
}

/** Draw of a layer what is chosen, and say what that is. */
function updateLayer(layer, i) {
    const {state, content} = layer, solid = !isFlat && state.inside;
    let list = [], drawn = 0;
    for (const object of content.children)
        object.geometry.dispose();
    content.remove(...content.children);
    if (chosen.brush) {
        if (!isFlat && !(solid && isComplete))
            list = brushed(state.bad);
        const inside = solid ? brushed(state.inside) : [];
        drawn = list.length + inside.length;
        if (solid)
            addElements(content, state.inside, inside, true);
    } else {
        list = Array.from({length: countWorse(state, limit())}, (_, k) => k);
    }
    addElements(content, state.bad, isFlat ? worstLast(list) : list, !isFlat);
    if (isFlat && !chosen.brush) /* inverted ones show from afar */
        content.add(makeDots(state.bad, list.slice(0, countWorse(state, Infinity))));
    clip(content);
    if (chosen.cut && isComplete)
        addElements(content, state.inside, crossing(state.inside), false);
    else if (chosen.cut && state.cubes)
        addSquares(content, state);
    if (layer.shape.facets)
        paintFacets(layer);
    layer.caption.textContent = chosen.brush ? describeBrush(state, i, drawn)
        : describe(state, limit(), textOf(limit()));
}

/** Draw what is chosen. */
function update() {
    const text = textOf(limit());
    part('worse-text').textContent = text;
    slider.setAttribute('aria-valuetext', text);
    slider.disabled = !(highest > lowest) || chosen.brush !== null;
    layers.forEach(updateLayer);
    drawSoon();
}

/** The legend of the colours of the chosen measure. */
function makeLegend() {
    const legend = part('colours'), measure = measures[chosen.measure], items = [];
    const add = (colour, text) => {
        const item = document.createElement('span'), key = document.createElement('i');
        key.style.background = colour;
        item.append(key, text);
        items.push(item);
    };
    const {limits, unit} = measure, n = limits.length;
    COLOURS.forEach((colour, i) => add(colour,
        i < n ? (measure.more_is_better ? 'from ' : 'to ') + limits[i] + unit
              : (measure.more_is_better ? 'less than ' : 'more than ') + limits[n - 1] + unit));
    add(INVERTED, 'inverted');
    legend.replaceChildren(measure.name + ': ', ...items);
}

/** Colours of light or dark pages. */
function applyTheme() {
    for (const {shape} of layers) {
        for (const skin of shape.skins)
            skin.material.color = themeColour('--skin');
        /* Lines of a flat mesh lie on its colours, which are the same on any page. */
        const ink = isFlat ? new THREE.Color('#22303c') : themeColour('--ink');
        shape.mesh.material.color = shape.frame.material.color = ink;
    }
    update();
}

return {update, makeLegend, applyTheme};
})();
