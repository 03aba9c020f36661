/* controls: the controls above the view: slider, lists and boxes. */
const planishControls = (function () {
'use strict';

const {picture, dim, extent, isFlat, states, measures, triangles} = planishData, {part} = planishPage;
const {chosen, slider, lowest, highest} = planishChosen, {plane, clipping, clip} = planishCut;
const {lookAtAll} = planishCamera, {holder, layers, drawSoon, resize} = planishView;
const {update, makeLegend} = planishContent;
const MOST_MESH_LINES = 60000; /* of a surface whose edges are drawn at first */
const AXES = ['x', 'y', 'z'];
const divider = part('divider');

/** Whether the edges of the mesh leave something to be seen between them. */
function hasRoomForLines() {
    const least = 30; /* pixels of a triangle */
    const scale = Math.min(holder.clientWidth / extent[0], holder.clientHeight / extent[1]);
    const room = extent[0] * extent[1] * scale * scale;
    return !picture.coarse && triangles.length / 2 <= MOST_MESH_LINES &&
        (dim === 3 || room / (triangles.length / 3) > least);
}

/** Make a checkbox show something. */
function connectBox(box, isChecked, show) {
    if (!box)
        return;
    box.checked = isChecked;
    const change = () => { show(box.checked); drawSoon(); };
    box.addEventListener('change', change);
    change();
}

function connectBoxes() {
    connectBox(part('lines'), hasRoomForLines(), isShown => {
        for (const {shape} of layers)
            shape.mesh.visible = isShown;
    });
    /* Of one state, features are what the picture is for. */
    connectBox(part('features'), states.length === 1, isShown => {
        for (const {shape} of layers) {
            shape.features.visible = isShown;
            if (shape.facets)
                shape.facets.visible = !isShown;
        }
    });
    connectBox(part('apart'), false, isApart => {
        chosen.apart = isApart;
        divider.hidden = part('divider-line').hidden = isApart;
        resize();
    });
}

/** The slider between the states before and after. */
function connectDivider() {
    if (!divider)
        return;
    const change = () => {
        chosen.divider = divider.value / 100;
        part('divider-line').style.left = divider.value + '%';
        divider.setAttribute('aria-valuetext', divider.value + ' % before, ' +
            (100 - divider.value) + ' % after');
        drawSoon();
    };
    divider.addEventListener('input', change);
    change();
}

function connectMeasure() {
    const list = part('measure');
    measures.forEach((measure, i) => list.append(new Option(measure.name, i)));
    list.addEventListener('change', () => {
        chosen.measure = Number(list.value);
        makeLegend();
        update();
    });
}

/** The place of the cut, in the units of the file. */
function showCut() {
    const axis = part('cut-axis').value, place = part('cut-place');
    chosen.cut = axis === '' ? null : {axis: Number(axis), place: place.value / place.max};
    clipping.length = 0;
    if (chosen.cut) {
        const text = (picture.low[axis] + chosen.cut.place * extent[axis]).toPrecision(4);
        clipping.push(plane);
        place.setAttribute('aria-valuetext', AXES[axis] + ' = ' + text);
        part('cut-text').textContent = AXES[axis] + ' = ' + text;
    }
    place.hidden = part('cut-text').hidden = part('cut-note').hidden = !chosen.cut;
    for (const layer of layers)
        clip(layer.shape.group);
    update();
}

function connectCut() {
    const axis = part('cut-axis');
    if (!axis)
        return;
    AXES.forEach((name, d) => axis.append(new Option(name, d)));
    axis.addEventListener('change', showCut);
    part('cut-place').addEventListener('input', showCut);
}

function connectSlider() {
    const start = isFlat ? lowest : Math.max(lowest, Math.min(picture.start, highest));
    const steps = slider.max / slider.step;
    slider.value = highest > lowest /* rounded down, so that what is just worse is seen */
        ? slider.step * Math.floor(steps * Math.log(start / lowest) / Math.log(highest / lowest)) : 0;
    slider.addEventListener('input', update);
}

function connectWhole() {
    part('whole').addEventListener('click', () => { lookAtAll(); drawSoon(); });
}

return {connectBoxes, connectDivider, connectMeasure, connectCut, connectSlider, connectWhole};
})();
