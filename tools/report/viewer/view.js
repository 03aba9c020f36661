/* view: the canvas: what is drawn on it and where, and how pointers and keys move it. */
const planishView = (function () {
'use strict';

const {dim, extent, states} = planishData, {section, part} = planishPage, {chosen} = planishChosen;
const {findEdges} = planishSurface, {makeShape} = planishShape, {turnPlane} = planishCut;
const {camera, target, lookAtAll, fitCamera, turn, pan, approach} = planishCamera;
const holder = part('view'), layers = [];
let renderer = null, asked = false;

/** The scene of a state; edges: those of the surface, or null. */
function makeLayer(state, edges, caption) {
    const scene = new THREE.Scene(), light = new THREE.DirectionalLight(0xffffff, 0.55);
    const shape = makeShape(state, edges), content = new THREE.Group();
    scene.add(shape.group, content, new THREE.AmbientLight(0xffffff, 0.45), light);
    return {state: state, shape: shape, content: content, scene: scene, light: light, caption: caption};
}

function makeLayers() {
    const captions = section.querySelectorAll('.count');
    let edges = null;
    states.forEach((state, i) => {
        if (i === 0 || state.points !== states[0].points)
            edges = findEdges(state.points);
        layers.push(makeLayer(state, edges, captions[i]));
    });
}

function drawSoon() {
    if (!asked)
        requestAnimationFrame(() => {
            asked = false;
            draw(holder.clientWidth, holder.clientHeight);
        });
    asked = true;
}

/** Turn by the arrow keys, or in 2-D move; + and - zoom, 0 shows all. */
function turnByKey(event) {
    const step = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]}[event.key];
    const closer = {'+': 0.8, '=': 0.8, '-': 1.25}[event.key];
    if (step && dim === 3)
        turn(step[0] * 0.15, step[1] * 0.15);
    else if (step)
        pan(step[0] * 0.05 / camera.zoom, step[1] * 0.05 / camera.zoom);
    else if (closer)
        approach(closer);
    else if (event.key === '0')
        lookAtAll();
    else
        return;
    event.preventDefault();
    drawSoon();
}

/** Make the canvas. Returns false if the browser has no WebGL. */
function makeCanvas() {
    const canvas = document.createElement('canvas');
    const context = canvas.getContext('webgl', {antialias: true, alpha: true, preserveDrawingBuffer: true});
    if (!context)
        return false;
    renderer = new THREE.WebGLRenderer({canvas: canvas, context: context, alpha: true});
    renderer.localClippingEnabled = true;
    canvas.tabIndex = 0;
    canvas.setAttribute('role', 'application');
    canvas.setAttribute('aria-describedby', 'picture-help');
    canvas.setAttribute('aria-label', holder.dataset.label);
    part('stills').replaceWith(canvas);
    const controls = new THREE.OrbitControls(camera, canvas);
    controls.target = target;
    controls.enableKeys = false;
    controls.screenSpacePanning = true;
    controls.enabled = false; /* wheel and fingers move the page until the picture is chosen */
    if (dim === 2) {
        controls.enableRotate = false;
        controls.mouseButtons.LEFT = THREE.MOUSE.PAN;
        controls.touches.ONE = THREE.TOUCH.PAN;
    }
    controls.addEventListener('change', drawSoon);
    canvas.addEventListener('pointerdown', event => {
        controls.enabled = controls.enabled || event.pointerType === 'mouse';
    }, true);
    canvas.addEventListener('focus', () => { controls.enabled = true; });
    canvas.addEventListener('blur', () => { controls.enabled = false; });
    canvas.addEventListener('keydown', turnByKey);
    canvas.addEventListener('webglcontextrestored', drawSoon);
    return true;
}

/** The pieces of the view: of each the layer, where it begins and ends (0 to 1), and where what it shows
 *  a part of does. */
function pieces() {
    if (layers.length === 1)
        return [[layers[0], 0, 1, 0, 1]];
    if (chosen.apart)
        return [[layers[0], 0, 0.5, 0, 0.5], [layers[1], 0.5, 1, 0.5, 1]];
    return [[layers[0], 0, chosen.divider, 0, 1], [layers[1], chosen.divider, 1, 0, 1]];
}

/** Draw on a canvas of a width and height. */
function draw(width, height) {
    turnPlane(camera);
    renderer.setScissorTest(true);
    for (const [layer, from, to, left, right] of pieces()) {
        if (to <= from)
            continue;
        fitCamera((right - left) * width, height);
        renderer.setViewport(left * width, 0, (right - left) * width, height);
        renderer.setScissor(from * width, 0, (to - from) * width, height);
        layer.light.position.copy(camera.position).sub(target);
        renderer.render(layer.scene, camera);
    }
}

/** Of a plane mesh that is wider than high, the view is no higher than it needs. */
function fitHeight() {
    holder.style.height = '';
    if (dim === 2 && extent[0] > 0) {
        const needed = 1.1 * holder.clientWidth * extent[1] / extent[0] / (chosen.apart ? 2 : 1);
        holder.style.height = Math.max(150, Math.min(holder.clientHeight, needed)) + 'px';
    }
}

function resize() {
    fitHeight();
    renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    renderer.setSize(holder.clientWidth, holder.clientHeight);
    drawSoon();
}

/** Return the canvas with what is chosen, width times height pixels large, until it is resized. */
function drawOnce(width, height) {
    renderer.setPixelRatio(1);
    renderer.setSize(width, height, false);
    draw(width, height);
    return renderer.domElement;
}

return {holder, layers, makeLayers, makeCanvas, drawSoon, drawOnce, resize};
})();
