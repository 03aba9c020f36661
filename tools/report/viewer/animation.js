/* animation: the mesh from sweep to sweep, where the page has such steps, in place of the mesh after all of
 * them. */
const planishAnimation = (function () {
'use strict';

const {picture, states, steps} = planishData, {section, part} = planishPage;
const {movePoints} = planishShape, {layers} = planishView, {update} = planishContent;
const SHOWN = 600; /* milliseconds for each */
const button = part('play'), slider = part('step'), divider = part('divider');
const all = [states[0], ...steps, states[states.length - 1]], last = all.length - 1;
const still = window.matchMedia('(prefers-reduced-motion: reduce)');
let timer = null;

function nameOf(i) {
    return all[i].sweep ? 'sweep ' + all[i].sweep + ' of ' + picture.sweeps : all[i].name;
}

/** Show state i. */
function show(i) {
    const layer = layers[1], name = nameOf(i);
    layer.state = all[i];
    movePoints(layer.shape, all[i].points);
    slider.value = i;
    slider.setAttribute('aria-valuetext', name);
    part('step-text').textContent = part('right').textContent = name;
    layer.caption.previousSibling.data = name + ': ';
    update();
}

/** Say on the button what it does. */
function nameButton() {
    button.textContent = timer !== null ? 'pause' : still.matches ? 'next state' : 'play';
}

function pause() {
    clearInterval(timer);
    timer = null;
    nameButton();
}

/** Show the next state; behind the last one comes the first. */
function advance() {
    show(Number(slider.value) < last ? Number(slider.value) + 1 : 0);
    if (Number(slider.value) === last)
        pause();
}

/** Let the view have nothing but the mesh from sweep to sweep. */
function makeRoom() {
    divider.value = 0;
    divider.dispatchEvent(new Event('input'));
}

/** Play or pause; without motion, go on by one state. */
function press() {
    if (timer !== null) {
        pause();
        return;
    }
    makeRoom();
    advance();
    if (!still.matches && Number(slider.value) < last)
        timer = setInterval(advance, SHOWN);
    nameButton();
}

function pressByKey(event) {
    if (event.key !== ' ')
        return;
    event.preventDefault();
    press();
}

function connectPlay() {
    if (!slider)
        return;
    button.addEventListener('click', press);
    slider.addEventListener('input', () => { pause(); show(Number(slider.value)); });
    section.querySelector('canvas').addEventListener('keydown', pressByKey);
    still.addEventListener('change', pause);
    show(last);
    nameButton();
}

return {connectPlay};
})();
