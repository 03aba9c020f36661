/* viewer: draws the picture of the mesh (viewer_data.js) in the page, with three.js: the surface and
 * elements inside it, or the triangles of a flat mesh. One view shows the states before and after, on
 * both sides of a divider. */
(function () {
'use strict';

const section = document.getElementById('picture');
if (!section || !planishData)
    return;

const {picture, dim, extent, size, states, measures, triangles, sides, features, corners} = planishData;
const CURVE = '#c2410c', CORNER = '#b91c1c';
const PATCHES = ['#4477aa', '#66ccee', '#228833', '#ccbb44', '#ee6677', '#aa3377', '#999933', '#777777'];
const CREASE = Math.cos(Math.PI / 7); /* sharper edges of the surface are drawn */
const FIELD_OF_VIEW = 35;       /* degrees */
const MOST_MESH_LINES = 60000;  /* of a surface whose edges are drawn at first */
const AXES = ['x', 'y', 'z'];
const isFlat = dim === 2 || picture.flat === true; /* all elements are drawn, in colours */
const isComplete = picture.stride === 1;           /* all elements inside are known */

/* What is chosen: the measure that colours elements; the bins of a histogram, or null; the axis and
 * place (0 to 1) of the cut, or null; the share of the view that is the first state's. */
const chosen = {measure: 0, brush: null, cut: null, divider: 0.5, apart: false};

/** The only element of a class in the picture, or null. */
function part(name) {
    return section.querySelector('.' + name);
}

/** A style sheet's variable as a colour. */
function themeColour(name) {
    return new THREE.Color(getComputedStyle(section).getPropertyValue(name).trim());
}

/** Red, green and blue of every code of a measure. */
const shades = measures.map(measure => {
    const rgb = new Float32Array(3 * 256), colour = new THREE.Color();
    measure.colour.forEach((text, code) => colour.set(text).toArray(rgb, 3 * code));
    return rgb;
});

/* ---- the surface ---------------------------------------------------------------------------- */

/** Normal of each triangle, three numbers each. */
function normalsOf(points) {
    const normals = new Float32Array(triangles.length), u = [0, 0, 0], v = [0, 0, 0];
    for (let i = 0; i < triangles.length; i += 3) {
        for (let d = 0; d < 3; d++) {
            u[d] = points[3 * triangles[i + 1] + d] - points[3 * triangles[i] + d];
            v[d] = points[3 * triangles[i + 2] + d] - points[3 * triangles[i] + d];
        }
        const x = u[1] * v[2] - u[2] * v[1], y = u[2] * v[0] - u[0] * v[2];
        const z = u[0] * v[1] - u[1] * v[0], length = Math.hypot(x, y, z) || 1;
        normals.set([x / length, y / length, z / length], i);
    }
    return normals;
}

/** Edges of the surface as pairs of points: all, and those where it has a crease or ends. The diagonals
 *  of quadrilaterals are none. */
function findEdges(points) {
    const n = points.length / 3, normals = normalsOf(points);
    const known = new Map(), pairs = [], owner = [], sharp = [];
    for (let k = 0; k < triangles.length; k++) {
        const i = Math.floor(k / 3), a = triangles[k], b = triangles[3 * i + (k + 1) % 3];
        if (sides && !(sides[i] >> k % 3 & 1))
            continue;
        const key = Math.min(a, b) * n + Math.max(a, b), edge = known.get(key);
        if (edge === undefined) {
            known.set(key, owner.length);
            pairs.push(a, b);
            owner.push(3 * i);
            sharp.push(true);
        } else {
            const j = owner[edge], cosine = normals[j] * normals[3 * i] +
                normals[j + 1] * normals[3 * i + 1] + normals[j + 2] * normals[3 * i + 2];
            sharp[edge] = dim === 3 && Math.abs(cosine) < CREASE;
        }
    }
    return {all: pairs, sharp: pairs.filter((_, i) => sharp[i >> 1])};
}

function lines(points, pairs, opacity) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(points, 3));
    geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(pairs), 1));
    return new THREE.LineSegments(geometry,
        new THREE.LineBasicMaterial({transparent: opacity < 1, opacity: opacity}));
}

/** A geometry of places with a colour each. */
function coloured(places, colours) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(places, 3));
    geometry.setAttribute('color', new THREE.BufferAttribute(colours, 3));
    return geometry;
}

/** The corners of all triangles, three numbers each. */
function trianglePlaces(points) {
    const places = new Float32Array(triangles.length * 3);
    for (let i = 0; i < triangles.length; i++)
        for (let d = 0; d < 3; d++)
            places[3 * i + d] = points[3 * triangles[i] + d];
    return places;
}

function shadedMaterial() {
    return new THREE.MeshPhongMaterial({vertexColors: THREE.VertexColors, flatShading: true,
        shininess: 0, side: THREE.DoubleSide});
}

function plainMaterial() {
    return new THREE.MeshBasicMaterial({vertexColors: THREE.VertexColors, side: THREE.DoubleSide});
}

/** The patch of each triangle: triangles whose common edges are no features are of one. */
function findPatches(n) {
    const parent = Array.from({length: triangles.length / 3}, (_, i) => i);
    const rootOf = i => {
        while (parent[i] !== i)
            i = parent[i] = parent[parent[i]];
        return i;
    };
    const keyOf = (a, b) => Math.min(a, b) * n + Math.max(a, b);
    const cut = new Set(), known = new Map(), numbers = new Map();
    for (let i = 0; i < features.length; i += 2)
        cut.add(keyOf(features[i], features[i + 1]));
    triangles.forEach((a, k) => {
        const i = Math.floor(k / 3), key = keyOf(a, triangles[3 * i + (k + 1) % 3]);
        if (cut.has(key))
            return;
        if (known.has(key))
            parent[rootOf(i)] = rootOf(known.get(key));
        else
            known.set(key, i);
    });
    return parent.map((_, i) => {
        const root = rootOf(i);
        if (!numbers.has(root))
            numbers.set(root, numbers.size);
        return numbers.get(root);
    });
}

/** The features of the surface of a state: patches in colours, curves, corners. */
function makeFeatures(state) {
    const group = new THREE.Group(), patch = findPatches(state.points.length / 3);
    const colours = new Float32Array(triangles.length * 3), colour = new THREE.Color();
    for (let i = 0; i < triangles.length; i++)
        colour.set(PATCHES[patch[Math.floor(i / 3)] % PATCHES.length]).toArray(colours, 3 * i);
    const skin = new THREE.Mesh(coloured(trianglePlaces(state.points), colours),
        Object.assign(shadedMaterial(), {transparent: true, depthWrite: false, opacity: 0.5}));
    const curves = lines(state.points, features, 1), dots = new THREE.BufferGeometry();
    curves.material.color.set(CURVE);
    dots.setAttribute('position', new THREE.BufferAttribute(state.points, 3));
    dots.setIndex(new THREE.BufferAttribute(corners, 1));
    skin.renderOrder = -1;
    group.add(skin, curves, new THREE.Points(dots,
        new THREE.PointsMaterial({size: 6, sizeAttenuation: false, color: CORNER})));
    return group;
}

/** The surface of solid elements, which can be looked into: its sides behind, and before, these. */
function makeSkins(points) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(points, 3));
    geometry.setIndex(new THREE.BufferAttribute(triangles, 1));
    return [THREE.BackSide, THREE.FrontSide].map((side, i) => {
        const mesh = new THREE.Mesh(geometry, new THREE.MeshPhongMaterial({flatShading: true,
            shininess: 0, side: side, transparent: true, depthWrite: false, opacity: i ? 0.12 : 0.5}));
        mesh.renderOrder = i ? 1 : -1;
        return mesh;
    });
}

/** All that is drawn of a state whatever is chosen. */
function makeShape(state, edges) {
    const shape = {group: new THREE.Group(), skins: [], facets: null, features: null};
    shape.mesh = lines(state.points, edges.all, dim === 3 ? 0.15 : 0.45);
    shape.frame = lines(state.points, edges.sharp, dim === 3 ? 0.8 : 1);
    if (isFlat) {
        const material = dim === 3 ? shadedMaterial() : plainMaterial();
        Object.assign(material, {polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1});
        shape.facets = new THREE.Mesh(coloured(trianglePlaces(state.points),
            new Float32Array(triangles.length * 3)), material);
        shape.group.add(shape.facets);
    } else {
        shape.skins = makeSkins(state.points);
        shape.group.add(...shape.skins);
    }
    if (dim === 2)
        shape.mesh.position.z = shape.frame.position.z = 0.002;
    shape.group.add(shape.mesh, shape.frame);
    if (features) {
        shape.features = makeFeatures(state);
        shape.group.add(shape.features);
    }
    return shape;
}

/** Colour the triangles of a flat mesh: those that are not chosen are pale. */
function paintFacets(layer) {
    const colours = layer.shape.facets.geometry.attributes.color, array = colours.array;
    const paper = themeColour('--panel').toArray(), m = chosen.measure, rgb = shades[m];
    const n = triangles.length / 3, codes = layer.state.codes, value = limit();
    for (let i = 0; i < n; i++) {
        const code = codes[m * n + i], isPale = chosen.brush
            ? !isBrushed(codes[chosen.brush.measure * n + i])
            : slider.value > 0 && !(measures[0].value[codes[i]] > value) && codes[i] > 0;
        for (let j = 0; j < 9; j++)
            array[9 * i + j] = rgb[3 * code + j % 3] * (isPale ? 0.15 : 1) +
                (isPale ? 0.85 * paper[j % 3] : 0);
    }
    colours.needsUpdate = true;
}

/* ---- elements ------------------------------------------------------------------------------- */

/* Triangles and edges of elements by the number of their corners, which stand in VTK's order. */
const FACES = isFlat ? {3: [0, 1, 2], 4: [0, 1, 2, 0, 2, 3]} : {
    4: [0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2],
    5: [0, 3, 2, 0, 2, 1, 0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4],
    6: [0, 2, 1, 3, 4, 5, 0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4, 2, 0, 3, 2, 3, 5],
    8: [0, 3, 2, 0, 2, 1, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4, 1, 2, 6, 1, 6, 5, 2, 3, 7, 2, 7, 6,
        3, 0, 4, 3, 4, 7]
};
const EDGES = isFlat ? {3: [0, 1, 1, 2, 2, 0], 4: [0, 1, 1, 2, 2, 3, 3, 0]} : {
    4: [0, 1, 0, 2, 0, 3, 1, 2, 1, 3, 2, 3],
    5: [0, 1, 1, 2, 2, 3, 3, 0, 0, 4, 1, 4, 2, 4, 3, 4],
    6: [0, 1, 1, 2, 2, 0, 3, 4, 4, 5, 5, 3, 0, 3, 1, 4, 2, 5],
    8: [0, 1, 1, 2, 2, 3, 3, 0, 4, 5, 5, 6, 6, 7, 7, 4, 0, 4, 1, 5, 2, 6, 3, 7]
};

/** The places of the corners that order has for each of the listed elements, and their colours. */
function gather(set, list, order) {
    let n = 0;
    for (const i of list)
        n += order[set.sizes[i]].length;
    const places = new Float32Array(3 * n), colours = new Float32Array(3 * n);
    const rgb = shades[chosen.measure], codes = chosen.measure * set.n;
    let at = 0;
    for (const i of list) {
        const code = 3 * set.codes[codes + i];
        for (const j of order[set.sizes[i]])
            for (let d = 0; d < 3; d++, at++) {
                places[at] = set.corners[3 * (set.first[i] + j) + d];
                colours[at] = rgb[code + d];
            }
    }
    return coloured(places, colours);
}

/** Middle of element i of a set. */
function middleOf(set, i) {
    const middle = [0, 0, 0];
    for (let j = set.first[i]; j < set.first[i + 1]; j++)
        for (let d = 0; d < 3; d++)
            middle[d] += set.corners[3 * j + d] / set.sizes[i];
    return middle;
}

/** Dots that show elements from afar. */
function makeDots(set, list) {
    const places = new Float32Array(3 * list.length), colours = new Float32Array(3 * list.length);
    list.forEach((i, k) => {
        places.set(middleOf(set, i), 3 * k);
        const code = 3 * set.codes[chosen.measure * set.n + i];
        colours.set(shades[chosen.measure].subarray(code, code + 3), 3 * k);
    });
    return new THREE.Points(coloured(places, colours), new THREE.PointsMaterial(
        {size: 4, sizeAttenuation: false, vertexColors: THREE.VertexColors}));
}

/** Elements of a set: solids, their edges, and dots if asked for. */
function addElements(group, set, list, hasDots) {
    if (!list.length)
        return;
    const solids = new THREE.Mesh(gather(set, list, FACES), dim === 3 ? shadedMaterial() : plainMaterial());
    Object.assign(solids.material, {polygonOffset: dim === 3, polygonOffsetFactor: 0.5,
        polygonOffsetUnits: 1});
    group.add(solids);
    if (dim === 3) /* those of a plane mesh are among its mesh lines */
        group.add(new THREE.LineSegments(gather(set, list, EDGES),
            new THREE.LineBasicMaterial({color: 0x222222})));
    else
        solids.position.z = 0.001;
    if (hasDots) {
        const dots = makeDots(set, list);
        dots.position.z = dim === 2 ? 0.003 : 0;
        group.add(dots);
    }
}

/** The elements of a set for which test(i) holds. */
function select(set, test) {
    const list = [];
    for (let i = 0; i < set.n; i++)
        if (test(i))
            list.push(i);
    return list;
}

/** How many bad elements are worse than value, inverted ones always. */
function countWorse(state, value) {
    const ratios = state.bad.ratios;
    let n = 0;
    while (n < ratios.length && !(ratios[n] > 0 && ratios[n] <= value))
        n++;
    return n;
}

/** Whether the code of an element, for the measure of the histogram, is in the chosen bins. */
function isBrushed(code) {
    return code >= chosen.brush.codes[0] && code <= chosen.brush.codes[1];
}

/** The chosen elements of a set by the bins of the histogram. */
function brushed(set) {
    return select(set, i => isBrushed(set.codes[chosen.brush.measure * set.n + i]));
}

/* ---- the cut -------------------------------------------------------------------------------- */

const plane = new THREE.Plane(new THREE.Vector3(1, 0, 0), 0);
const clipping = []; /* [plane] while there is a cut */

function cutPlace() {
    const axis = chosen.cut.axis;
    return (chosen.cut.place - 0.5) * extent[axis] / size;
}

/** The elements that the cut goes through. */
function crossing(set) {
    const axis = chosen.cut.axis, at = cutPlace();
    return select(set, i => {
        let low = Infinity, high = -Infinity;
        for (let j = set.first[i]; j < set.first[i + 1]; j++) {
            low = Math.min(low, set.corners[3 * j + axis]);
            high = Math.max(high, set.corners[3 * j + axis]);
        }
        return low <= at && high >= at && high > low;
    });
}

/** Squares where the cut goes through cubes of the grid, each in the colour of its worst element. */
function addSquares(group, state) {
    const axis = chosen.cut.axis, [u, v] = [0, 1, 2].filter(d => d !== axis);
    const n = picture.grid.n, step = [1, n[0], n[0] * n[1]], side = picture.grid.size / size;
    const layer = Math.min(n[axis] - 1, Math.floor(chosen.cut.place * extent[axis] / picture.grid.size));
    const codes = chosen.measure * n[0] * n[1] * n[2] + layer * step[axis];
    const places = [], colours = [], rgb = shades[chosen.measure];
    for (let j = 0; j < n[v]; j++)
        for (let i = 0; i < n[u]; i++) {
            const code = state.cubes[codes + i * step[u] + j * step[v]];
            if (code === planishData.NOTHING)
                continue;
            for (const [a, b] of [[0, 0], [1, 0], [1, 1], [0, 0], [1, 1], [0, 1]]) {
                const place = [0, 0, 0];
                place[axis] = cutPlace();
                place[u] = (i + a) * side - extent[u] / size / 2;
                place[v] = (j + b) * side - extent[v] / size / 2;
                places.push(...place);
                colours.push(rgb[3 * code], rgb[3 * code + 1], rgb[3 * code + 2]);
            }
        }
    group.add(new THREE.Mesh(coloured(new Float32Array(places), new Float32Array(colours)),
        plainMaterial()));
}

/** Take away the half of the mesh that is before the cut. */
function turnPlane() {
    if (!chosen.cut)
        return;
    const axis = chosen.cut.axis, at = cutPlace();
    const sign = camera.position.getComponent(axis) > at ? -1 : 1;
    plane.normal.set(0, 0, 0).setComponent(axis, sign);
    plane.constant = -sign * at;
}

function clip(group) {
    group.traverse(object => {
        if (object.material)
            object.material.clippingPlanes = clipping;
    });
}

/* ---- the view ------------------------------------------------------------------------------- */

const camera = dim === 3 ? new THREE.PerspectiveCamera(FIELD_OF_VIEW, 1, 0.001, 100)
                         : new THREE.OrthographicCamera(-1, 1, 1, -1, -10, 10);
const target = new THREE.Vector3();
const holder = part('view'), divider = part('divider'), slider = part('worse');
let renderer = null, layers = [];

/** See the whole mesh. */
function lookAtAll() {
    target.set(0, 0, 0);
    camera.zoom = 1;
    if (dim === 3) {
        const radius = Math.hypot(...extent) / size / 2;
        const angle = FIELD_OF_VIEW / 2 * Math.PI / 180;
        const farther = camera.aspect < 1 ? 1 / camera.aspect : 1;
        camera.position.set(0.45, -0.75, 0.48).setLength(farther * radius / Math.sin(angle));
    } else {
        camera.position.set(0, 0, 1);
    }
    camera.lookAt(target);
    camera.updateProjectionMatrix();
}

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
    layers = states.map((state, i) => {
        if (i === 0 || state.points !== states[0].points)
            edges = findEdges(state.points);
        return makeLayer(state, edges, captions[i]);
    });
}

function makeCanvas() {
    renderer = new THREE.WebGLRenderer(
        {antialias: true, alpha: true, preserveDrawingBuffer: true}); /* else it does not print */
    renderer.localClippingEnabled = true;
    const canvas = renderer.domElement;
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

function turn(around, over) {
    const offset = camera.position.clone().sub(target).applyAxisAngle(camera.up, -around);
    const side = new THREE.Vector3().crossVectors(camera.up, offset).normalize();
    const turned = offset.clone().applyAxisAngle(side, -over);
    if (turned.angleTo(camera.up) > 0.05 && turned.angleTo(camera.up) < Math.PI - 0.05)
        offset.copy(turned);
    camera.position.copy(target).add(offset);
    camera.lookAt(target);
}

function pan(x, y) {
    const by = new THREE.Vector3(x, y, 0);
    target.add(by);
    camera.position.add(by);
}

function approach(factor) {
    if (dim === 3)
        camera.position.sub(target).multiplyScalar(factor).add(target);
    camera.zoom = dim === 2 ? camera.zoom / factor : 1;
    camera.updateProjectionMatrix();
}

let asked = false;
function drawSoon() {
    if (!asked)
        requestAnimationFrame(draw);
    asked = true;
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

/** Fit the camera to a width and height in pixels. */
function fitCamera(width, height) {
    if (dim === 3) { /* from an element of any size to the whole mesh */
        const distance = camera.position.distanceTo(target);
        camera.aspect = width / height;
        camera.near = distance / 100;
        camera.far = distance + 10;
    } else { /* the box fills the view */
        const half = 0.53 / size * Math.max(extent[1], extent[0] * height / width);
        camera.top = half;
        camera.bottom = -half;
        camera.right = half * width / height;
        camera.left = -camera.right;
    }
    camera.updateProjectionMatrix();
}

function draw() {
    asked = false;
    const width = holder.clientWidth, height = holder.clientHeight;
    turnPlane();
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

/* ---- what is chosen ------------------------------------------------------------------------- */

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

function plural(n, noun) {
    return n.toLocaleString('en') + ' ' + noun + (n === 1 ? '' : 's');
}

function textOf(value) {
    return value < 1000 ? value.toPrecision(3)
        : value < 1e7 ? Math.round(value).toLocaleString('en')
        : value < Infinity ? value.toPrecision(3) : 'any';
}

/** What is shown of the elements of a histogram's bins; drawn: how many of them are. */
function describeBrush(i, drawn) {
    const brush = chosen.brush, measure = measures[brush.measure];
    const to = measure.edges[brush.to], n = brush.counts[i];
    const text = plural(n, 'element') + ', ' + measure.name + ' ' + measure.edges[brush.from] +
        measure.unit + (to === null ? ' and more' : ' to ' + to + measure.unit);
    return isFlat || drawn >= n ? text : text + '; ' + drawn.toLocaleString('en') + ' of them are drawn';
}

/** What a view shows, in words. */
function describe(state, value, text) {
    const drawn = countWorse(state, Infinity), n = countWorse(state, value);
    if (value === Infinity || drawn < state.inverted) // more than are drawn, whatever the value
        return plural(state.inverted, 'inverted element') +
            (drawn < state.inverted ? ', of which ' + drawn.toLocaleString('en') + ' are drawn' : '');
    return plural(n, 'element') + ' worse than ' + text +
        (drawn ? ', ' + drawn.toLocaleString('en') + ' of them inverted' : '');
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
        for (let k = 0; k < countWorse(state, limit()); k++)
            list.push(k);
    }
    addElements(content, state.bad, list, dim === 3);
    if (dim === 2 && !chosen.brush) /* inverted ones show from afar */
        content.add(makeDots(state.bad, list.slice(0, countWorse(state, Infinity))));
    clip(content);
    if (chosen.cut && isComplete)
        addElements(content, state.inside, crossing(state.inside), false);
    else if (chosen.cut)
        addSquares(content, state);
    if (layer.shape.facets)
        paintFacets(layer);
    layer.caption.textContent = chosen.brush ? describeBrush(i, drawn)
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
    planishData.COLOURS.forEach((colour, i) => add(colour,
        i < n ? (measure.more_is_better ? 'from ' : 'to ') + limits[i] + unit
              : (measure.more_is_better ? 'less than ' : 'more than ') + limits[n - 1] + unit));
    add(planishData.INVERTED, 'inverted');
    legend.replaceChildren(measure.name + ': ', ...items);
}

/** A place of the file in the coordinates that are drawn: those in the plane of a mesh that is not
 *  in the plane of x and y. */
function toDrawn(place) {
    return picture.directions
        ? picture.directions.map(along => along.reduce((sum, a, d) =>
            sum + a * (place[d] - picture.origin[d]), 0)) : place;
}

/** Half the size of an element, by its corners and middle. */
function reachOf(set, i, middle) {
    let reach = 0;
    for (let j = 3 * set.first[i]; j < 3 * set.first[i + 1]; j++)
        reach = Math.max(reach, 2 * Math.abs(set.corners[j] - middle[j % 3]));
    return reach;
}

/** Go near the bad element whose middle is at place (in the file's coordinates). */
function visit(place) {
    const at = toDrawn(place).map((x, d) => (x - (picture.low[d] + picture.high[d]) / 2) / size);
    let best = Infinity, reach = 0.05;
    for (const {bad} of states)
        for (let i = 0; i < bad.n; i++) {
            const middle = middleOf(bad, i), distance = Math.hypot(...at.map((x, d) => x - middle[d]));
            if (distance < best) {
                best = distance;
                reach = reachOf(bad, i, middle);
            }
        }
    const offset = camera.position.clone().sub(target);
    target.set(at[0], at[1], at[2] || 0);
    camera.position.copy(target).add(dim === 3 ? offset.setLength(8 * reach + 1e-6) : offset);
    if (dim === 2)
        camera.zoom = 0.2 / (reach + 1e-9);
    camera.lookAt(target);
    section.scrollIntoView({block: 'start'});
    drawSoon();
}

/* ---- controls ------------------------------------------------------------------------------- */

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

/* ---- histograms ----------------------------------------------------------------------------- */

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

/* ---- begin ---------------------------------------------------------------------------------- */

function connectSlider() {
    const start = isFlat ? lowest : Math.max(lowest, Math.min(3, highest));
    slider.value = highest > lowest
        ? slider.max * Math.log(start / lowest) / Math.log(highest / lowest) : 0;
    slider.addEventListener('input', update);
}

function connectButtons() {
    part('whole').addEventListener('click', () => { lookAtAll(); drawSoon(); });
    for (const button of document.querySelectorAll('button[data-place]')) {
        const place = button.dataset.place.split(',').map(Number);
        button.hidden = place.length !== (picture.directions ? 3 : dim) || !place.every(Number.isFinite);
        button.addEventListener('click', () => visit(place));
    }
}

/** Paper shows both states beside one another. */
function connectPrint() {
    window.addEventListener('beforeprint', () => {
        const before = chosen.apart;
        chosen.apart = layers.length > 1;
        draw();
        chosen.apart = before;
    });
    window.addEventListener('afterprint', drawSoon);
}

function hasWebGL() {
    const context = document.createElement('canvas').getContext('webgl');
    const lose = context && context.getExtension('WEBGL_lose_context');
    if (lose)
        lose.loseContext();
    return !!context;
}

if (!hasWebGL()) {
    part('fallback').textContent = 'This browser has no WebGL: the picture is a still one.';
    return;
}
part('fallback').remove();
camera.up.set(0, dim === 3 ? 0 : 1, dim === 3 ? 1 : 0);
makeLayers();
makeCanvas();
for (const hidden of section.querySelectorAll(
    '.controls, .help, .colours, .on-view, figcaption'))
    hidden.hidden = false;
resize();
fitCamera(holder.clientWidth, holder.clientHeight);
lookAtAll();
connectSlider();
connectMeasure();
connectCut();
connectDivider();
connectHistograms();
connectButtons();
connectPrint();
makeLegend();
applyTheme();
connectBoxes();
window.addEventListener('resize', resize);
window.matchMedia('(prefers-color-scheme: dark)').addEventListener('change', applyTheme);
})();
