/* viewer: draws the picture of the mesh (picture.c) in the page, with three.js: the surface and the
 * bad elements in it, or the triangles of a plane mesh; all states are seen by one camera. */
(function () {
'use strict';

const section = document.getElementById('picture');
const source = document.getElementById('picture-data');
if (!section || !source)
    return;

/* Ratio up to which each colour is used; from good to bad, told apart by lightness, too. */
const CLASSES = [[1.1, '#e6eef6'], [1.25, '#bcd5ea'], [1.5, '#86b6da'], [2, '#fde6a9'],
    [3, '#fdbb63'], [5, '#f5853f'], [10, '#dd3d2d'], [Infinity, '#8f0d1d']];
const INVERTED = '#d600c8';
const STEPS_PER_E = 50;         /* picture.c */
const CURVE = '#c2410c', CORNER = '#b91c1c';
const PATCHES = ['#4477aa', '#66ccee', '#228833', '#ccbb44', '#ee6677', '#aa3377', '#999933', '#777777'];
const CREASE = Math.cos(Math.PI / 7); /* sharper edges of the surface are drawn */
const FIELD_OF_VIEW = 35;       /* degrees */
const MOST_MESH_LINES = 60000;  /* of a surface whose edges are drawn at first */

/* ---- data --------------------------------------------------------------------------------- */

const picture = JSON.parse(source.textContent);
const dim = picture.dim;
const extent = [0, 1, 2].map(d => picture.high[d] - picture.low[d]);
const size = Math.max(...extent) > 0 ? Math.max(...extent) : 1;

function bytesOf(base64) {
    return Uint8Array.from(atob(base64), c => c.charCodeAt(0));
}

/** Places of the points, three numbers each; the box is around 0 and its longest side is 1. */
function placesOf(base64) {
    const from = new Uint16Array(bytesOf(base64).buffer);
    const places = new Float32Array(from.length / dim * 3);
    for (let i = 0; i < from.length; i++) {
        const d = i % dim;
        places[(i - d) / dim * 3 + d] = (from[i] / 65535 - 0.5) * extent[d] / size;
    }
    return places;
}

function unpackState(state, first) {
    const points = state.points ? placesOf(state.points) : first.points;
    const badRatios = new Float32Array(bytesOf(state.bad_ratios).buffer);
    const sizes = state.sizes ? bytesOf(state.sizes) : new Uint8Array(badRatios.length).fill(dim + 1);
    const firstCorner = [0];
    sizes.forEach((n, i) => firstCorner.push(firstCorner[i] + n));
    return {
        name: state.name,
        points: points,
        ratios: state.ratios ? bytesOf(state.ratios) : null,
        corners: new Float32Array(bytesOf(state.corners).buffer),
        sizes: sizes,              /* corners of each bad element, */
        firstCorner: firstCorner, /* and which is its first one */
        badRatios: badRatios,
        inverted: state.inverted
    };
}

/** Numbers of points. */
function numbersOf(base64) {
    const bytes = bytesOf(base64);
    return picture.index_bits === 16 ? new Uint16Array(bytes.buffer) : new Uint32Array(bytes.buffer);
}

const triangles = numbersOf(picture.triangles);
const features = picture.features !== undefined ? numbersOf(picture.features) : null; /* pairs */
const corners = features ? numbersOf(picture.corners) : null;
const sides = picture.sides ? bytesOf(picture.sides) : null; /* bit j: side j is an edge */
const states = [];
for (const state of picture.states)
    states.push(unpackState(state, states[0]));
source.textContent = '';

/* ---- colours ------------------------------------------------------------------------------ */

function colourOf(ratio) {
    return ratio > 0 ? CLASSES.find(c => ratio <= c[0])[1] : INVERTED;
}

/** A style sheet's variable as a colour. */
function themeColour(name) {
    return new THREE.Color(getComputedStyle(section).getPropertyValue(name).trim());
}

function makeLegend() {
    const legend = section.querySelector('.colours');
    const add = (colour, text) => {
        const item = document.createElement('span');
        const key = document.createElement('i');
        key.style.background = colour;
        item.append(key, text);
        legend.append(item);
    };
    const shown = dim === 2 ? CLASSES : CLASSES.slice(3);
    for (const [limit, colour] of shown)
        add(colour, limit === Infinity ? 'more than ' + CLASSES[CLASSES.length - 2][0]
                                       : 'to ' + limit);
    add(INVERTED, 'inverted');
}

/* ---- geometry ----------------------------------------------------------------------------- */

function normalOf(points, i) {
    const a = triangles[i] * 3, b = triangles[i + 1] * 3, c = triangles[i + 2] * 3;
    const u = [0, 1, 2].map(d => points[b + d] - points[a + d]);
    const v = [0, 1, 2].map(d => points[c + d] - points[a + d]);
    const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    const length = Math.hypot(...n) || 1;
    return n.map(x => x / length);
}

/** Edges of the surface as pairs of points: all, and those where it has a crease or ends. The diagonals
 *  of quadrilaterals are none. */
function findEdges(points) {
    const known = new Map(), n = points.length / 3;
    for (let i = 0; i < triangles.length; i += 3) {
        const normal = dim === 3 ? normalOf(points, i) : null;
        for (let j = 0; j < 3; j++) {
            const a = triangles[i + j], b = triangles[i + (j + 1) % 3];
            const key = Math.min(a, b) * n + Math.max(a, b);
            if (sides && !(sides[i / 3] >> j & 1))
                continue;
            const edge = known.get(key);
            if (!edge) {
                known.set(key, {a: a, b: b, normal: normal, sharp: true});
            } else if (normal) {
                const cosine = edge.normal[0] * normal[0] + edge.normal[1] * normal[1] +
                    edge.normal[2] * normal[2];
                edge.sharp = Math.abs(cosine) < CREASE;
            } else {
                edge.sharp = false;
            }
        }
    }
    const all = [], sharp = [];
    for (const edge of known.values()) {
        all.push(edge.a, edge.b);
        if (edge.sharp)
            sharp.push(edge.a, edge.b);
    }
    return {all: all, sharp: sharp};
}

function lines(points, pairs, colour, opacity) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(points, 3));
    geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(pairs), 1));
    return new THREE.LineSegments(geometry, new THREE.LineBasicMaterial(
        {color: colour, transparent: opacity < 1, opacity: opacity}));
}

/** Triangles with a colour each: places [n][3][3], colour(i) of triangle i. */
function colouredTriangles(places, colour) {
    const colours = new Float32Array(places.length), mixed = new THREE.Color();
    for (let i = 0; i < places.length / 9; i++) {
        mixed.set(colour(i));
        for (let j = 0; j < 3; j++)
            mixed.toArray(colours, 9 * i + 3 * j);
    }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(places, 3));
    geometry.setAttribute('color', new THREE.BufferAttribute(colours, 3));
    return geometry;
}

/* Triangles and edges of elements by the number of their corners, which stand in VTK's order. */
const FACES = dim === 3 && !picture.flat ? {
    4: [0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2],
    5: [0, 3, 2, 0, 2, 1, 0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4],
    6: [0, 2, 1, 3, 4, 5, 0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4, 2, 0, 3, 2, 3, 5],
    8: [0, 3, 2, 0, 2, 1, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4, 1, 2, 6, 1, 6, 5, 2, 3, 7, 2, 7, 6,
        3, 0, 4, 3, 4, 7]
} : {3: [0, 1, 2], 4: [0, 1, 2, 0, 2, 3]};
const EDGES = dim === 3 && !picture.flat ? {
    4: [0, 1, 0, 2, 0, 3, 1, 2, 1, 3, 2, 3],
    5: [0, 1, 1, 2, 2, 3, 3, 0, 0, 4, 1, 4, 2, 4, 3, 4],
    6: [0, 1, 1, 2, 2, 0, 3, 4, 4, 5, 5, 3, 0, 3, 1, 4, 2, 5],
    8: [0, 1, 1, 2, 2, 3, 3, 0, 4, 5, 5, 6, 6, 7, 7, 4, 0, 4, 1, 5, 2, 6, 3, 7]
} : {3: [0, 1, 1, 2, 2, 0], 4: [0, 1, 1, 2, 2, 3, 3, 0]};

/** Where the corners that order has for each bad element end, and their places, three numbers each. */
function cornerPlaces(state, order) {
    const ends = [0];
    state.sizes.forEach((n, i) => ends.push(ends[i] + order[n].length));
    const places = new Float32Array(ends[state.sizes.length] * 3);
    let at = 0;
    for (let i = 0; i < state.sizes.length; i++)
        for (const j of order[state.sizes[i]])
            for (let d = 0; d < 3; d++)
                places[at++] = d < dim ? state.corners[(state.firstCorner[i] + j) * dim + d] : 0.001;
    return {ends: ends, places: places};
}

function middlePlaces(state) {
    const n = state.badRatios.length, places = new Float32Array(n * 3);
    for (let i = 0; i < n; i++)
        for (let j = 0; j < state.sizes[i]; j++)
            for (let d = 0; d < dim; d++)
                places[3 * i + d] += state.corners[(state.firstCorner[i] + j) * dim + d] /
                    state.sizes[i];
    return places;
}

/** The bad elements of a state: solids, their edges, and dots that show them from afar. */
function makeBad(state) {
    const group = new THREE.Group();
    const faces = cornerPlaces(state, FACES), lines = cornerPlaces(state, EDGES);
    const elementOf = [];
    state.sizes.forEach((n, i) => FACES[n].forEach((j, k) => k % 3 || elementOf.push(i)));
    const colour = i => colourOf(state.badRatios[elementOf[i]]);
    const material = dim === 3
        ? new THREE.MeshPhongMaterial({vertexColors: THREE.VertexColors, flatShading: true,
            shininess: 0, side: THREE.DoubleSide})
        : new THREE.MeshBasicMaterial({vertexColors: THREE.VertexColors, side: THREE.DoubleSide});
    const solids = colouredTriangles(faces.places, colour);
    const edges = new THREE.BufferGeometry();
    edges.setAttribute('position', new THREE.BufferAttribute(lines.places, 3));
    const dots = new THREE.BufferGeometry();
    const colours = new Float32Array(state.badRatios.length * 3), mixed = new THREE.Color();
    state.badRatios.forEach((ratio, i) => mixed.set(colourOf(ratio)).toArray(colours, 3 * i));
    dots.setAttribute('position', new THREE.BufferAttribute(middlePlaces(state), 3));
    dots.setAttribute('color', new THREE.BufferAttribute(colours, 3));
    group.add(new THREE.Mesh(solids, material));
    if (dim === 3) /* those of a plane mesh are among its mesh lines */
        group.add(new THREE.LineSegments(edges, new THREE.LineBasicMaterial({color: 0x222222})));
    group.add(new THREE.Points(dots, new THREE.PointsMaterial(
        {size: 4, sizeAttenuation: false, vertexColors: THREE.VertexColors})));
    /* The first n are the worst n. */
    group.show = n => {
        solids.setDrawRange(0, faces.ends[n]);
        edges.setDrawRange(0, lines.ends[n]);
        dots.setDrawRange(0, dim === 3 ? n : countWorse(state, Infinity));
    };
    return group;
}

/** How many are worse than limit, inverted ones always. */
function countWorse(state, limit) {
    let n = 0;
    while (n < state.badRatios.length && !(state.badRatios[n] > 0 && state.badRatios[n] <= limit))
        n++;
    return n;
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
    const places = new Float32Array(triangles.length * 3);
    triangles.forEach((point, i) => places.set(state.points.subarray(3 * point, 3 * point + 3), 3 * i));
    const skin = new THREE.Mesh(colouredTriangles(places, i => PATCHES[patch[i] % PATCHES.length]),
        new THREE.MeshPhongMaterial({vertexColors: THREE.VertexColors, flatShading: true, shininess: 0,
            side: THREE.DoubleSide, transparent: true, depthWrite: false, opacity: 0.5}));
    const dots = new THREE.BufferGeometry();
    dots.setAttribute('position', new THREE.BufferAttribute(state.points, 3));
    dots.setIndex(new THREE.BufferAttribute(corners, 1));
    skin.renderOrder = -1;
    group.add(skin, lines(state.points, features, CURVE, 1), new THREE.Points(dots,
        new THREE.PointsMaterial({size: 6, sizeAttenuation: false, color: CORNER})));
    return group;
}

/** The surface of a solid, which can be looked into. */
function makeSolid(state, edges) {
    const group = new THREE.Group();
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(state.points, 3));
    geometry.setIndex(new THREE.BufferAttribute(triangles, 1));
    const skin = side => new THREE.MeshPhongMaterial({flatShading: true, shininess: 0, side: side,
        transparent: true, depthWrite: false, opacity: side === THREE.BackSide ? 0.5 : 0.12});
    group.skins = [skin(THREE.BackSide), skin(THREE.FrontSide)];
    group.skins.forEach((material, i) => {
        const mesh = new THREE.Mesh(geometry, material);
        mesh.renderOrder = i === 0 ? -1 : 1; /* behind, and before, the bad elements */
        group.add(mesh);
    });
    group.mesh = lines(state.points, edges.all, 0, 0.15);
    group.frame = lines(state.points, edges.sharp, 0, 0.8);
    group.add(group.mesh, group.frame);
    group.features = features ? makeFeatures(state) : null;
    if (features)
        group.add(group.features);
    return group;
}

/** A plane mesh, each element in the colour of its ratio. */
function makePlane(state, edges) {
    const group = new THREE.Group();
    const places = new Float32Array(triangles.length * 3);
    triangles.forEach((point, i) => places.set(state.points.subarray(3 * point, 3 * point + 3), 3 * i));
    const ratioOf = i => state.ratios[i] && Math.exp((state.ratios[i] - 0.5) / STEPS_PER_E);
    const material = new THREE.MeshBasicMaterial(
        {vertexColors: THREE.VertexColors, side: THREE.DoubleSide});
    const geometry = colouredTriangles(places, i => colourOf(ratioOf(i)));
    group.skins = [];
    group.add(new THREE.Mesh(geometry, material));
    /* Those that are not worse than limit are pale. */
    group.showWorse = limit => {
        const paper = themeColour('--panel'), mixed = new THREE.Color();
        const colours = geometry.attributes.color;
        for (let i = 0; i < state.ratios.length; i++) {
            const ratio = ratioOf(i);
            mixed.set(colourOf(ratio));
            if (ratio > 0 && ratio <= limit)
                mixed.lerp(paper, 0.85);
            for (let j = 0; j < 3; j++)
                mixed.toArray(colours.array, 9 * i + 3 * j);
        }
        colours.needsUpdate = true;
    };
    group.mesh = lines(state.points, edges.all, 0, 0.45);
    group.frame = lines(state.points, edges.sharp, 0, 1);
    group.mesh.position.z = group.frame.position.z = 0.002;
    group.add(group.mesh, group.frame);
    return group;
}

/* ---- views -------------------------------------------------------------------------------- */

const camera = dim === 3 ? new THREE.PerspectiveCamera(FIELD_OF_VIEW, 1, 0.001, 100)
                         : new THREE.OrthographicCamera(-1, 1, 1, -1, -10, 10);
const target = new THREE.Vector3();
const views = [];

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

function makeView(state, holder) {
    const renderer = new THREE.WebGLRenderer(
        {antialias: true, alpha: true, preserveDrawingBuffer: true}); /* else it does not print */
    const scene = new THREE.Scene(), canvas = renderer.domElement;
    const edges = views.length && views[0].state.points === state.points ? views[0].edges
                                                                        : findEdges(state.points);
    const shape = dim === 3 ? makeSolid(state, edges) : makePlane(state, edges);
    const bad = makeBad(state);
    const light = new THREE.DirectionalLight(0xffffff, 0.75);
    scene.add(shape, bad, new THREE.AmbientLight(0xffffff, 0.45), light);
    canvas.tabIndex = 0;
    canvas.setAttribute('role', 'application');
    canvas.setAttribute('aria-describedby', 'picture-help');
    canvas.setAttribute('aria-label', holder.dataset.label);
    holder.replaceChildren(canvas);
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
    return {state: state, edges: edges, renderer: renderer, scene: scene, shape: shape, bad: bad,
        light: light, holder: holder, caption: holder.parentNode.querySelector('.count')};
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

function draw() {
    asked = false;
    if (dim === 3) { /* from an element of any size to the whole mesh */
        const distance = camera.position.distanceTo(target);
        camera.near = distance / 100;
        camera.far = distance + 10;
        camera.updateProjectionMatrix();
    }
    for (const view of views) {
        view.light.position.copy(camera.position).sub(target);
        view.renderer.render(view.scene, camera);
    }
}

/** Of a plane mesh that is wider than high, the view is no higher than it needs. */
function fitHeight(holder) {
    holder.style.height = '';
    if (dim === 2 && extent[0] > 0) {
        const needed = 1.1 * holder.clientWidth * extent[1] / extent[0];
        holder.style.height = Math.max(100, Math.min(holder.clientHeight, needed)) + 'px';
    }
}

function resize() {
    for (const view of views) {
        fitHeight(view.holder);
        const width = view.holder.clientWidth, height = view.holder.clientHeight;
        view.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
        view.renderer.setSize(width, height);
        if (dim === 3) {
            camera.aspect = width / height;
        } else { /* the box fills the view */
            const half = 0.53 / size * Math.max(extent[1], extent[0] * height / width);
            camera.top = half;
            camera.bottom = -half;
            camera.right = half * width / height;
            camera.left = -camera.right;
        }
        camera.updateProjectionMatrix();
    }
    drawSoon();
}

/** Colours of light or dark pages. */
function applyTheme() {
    for (const view of views) {
        for (const skin of view.shape.skins)
            skin.color = themeColour('--skin');
        /* Lines of a plane mesh lie on its colours, which are the same on any page. */
        const ink = dim === 3 ? themeColour('--ink') : new THREE.Color('#22303c');
        view.shape.mesh.material.color = view.shape.frame.material.color = ink;
    }
    drawSoon();
}

/* ---- controls ----------------------------------------------------------------------------- */

const slider = section.querySelector('input[type=range]');

/** The range of ratios for which all worse elements are known, in every state: empty, from
 *  infinity, where there are more inverted ones than are drawn in all of them. */
function findRange() {
    let low = 1, high = 1, anyFinite = false;
    for (const state of states) {
        const n = state.badRatios.length, last = n ? state.badRatios[n - 1] : 1;
        if (n < picture.elements && last > 0)
            low = Math.max(low, last);
        anyFinite = anyFinite || n === 0 || last > 0;
        for (const ratio of state.badRatios)
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

/** What a view shows, in words. */
function describe(state, value, text) {
    const drawn = countWorse(state, Infinity), n = countWorse(state, value);
    if (value === Infinity || drawn < state.inverted) // more than are drawn, whatever the value
        return plural(state.inverted, 'inverted element') +
            (drawn < state.inverted ? ', of which ' + drawn.toLocaleString('en') + ' are drawn' : '');
    return plural(n, 'element') + ' worse than ' + text +
        (drawn ? ', ' + drawn.toLocaleString('en') + ' of them inverted' : '');
}

function showWorse() {
    const value = limit();
    const text = value < 1000 ? value.toPrecision(3)
        : value < 1e7 ? Math.round(value).toLocaleString('en')
        : value < Infinity ? value.toPrecision(3) : 'any';
    section.querySelector('output').textContent = text;
    slider.setAttribute('aria-valuetext', text);
    for (const view of views) {
        view.bad.show(countWorse(view.state, value));
        if (view.shape.showWorse)
            view.shape.showWorse(slider.value > 0 ? value : 0);
        view.caption.textContent = describe(view.state, value, text);
    }
    drawSoon();
}

/** A place of the file in the coordinates that are drawn: those in the plane of a mesh that is not
 *  in the plane of x and y. */
function toDrawn(place) {
    return picture.directions
        ? picture.directions.map(along => along.reduce((sum, a, d) =>
            sum + a * (place[d] - picture.origin[d]), 0)) : place;
}

/** Go near the bad element whose middle is at place (in the file's coordinates). */
function visit(place) {
    const at = toDrawn(place).map((x, d) => (x - (picture.low[d] + picture.high[d]) / 2) / size);
    let best = Infinity, extentOfBest = 0.05;
    for (const state of states) {
        const middles = middlePlaces(state);
        for (let i = 0; i < state.badRatios.length; i++) {
            const distance = Math.hypot(...at.map((x, d) => x - middles[3 * i + d]));
            if (distance >= best)
                continue;
            best = distance;
            extentOfBest = 0;
            for (let j = 0; j < state.sizes[i] * dim; j++)
                extentOfBest = Math.max(extentOfBest, 2 * Math.abs(
                    state.corners[state.firstCorner[i] * dim + j] - middles[3 * i + j % dim]));
        }
    }
    const offset = camera.position.clone().sub(target);
    target.set(at[0], at[1], at[2] || 0);
    camera.position.copy(target).add(dim === 3 ? offset.setLength(8 * extentOfBest + 1e-6) : offset);
    if (dim === 2)
        camera.zoom = 0.2 / (extentOfBest + 1e-9);
    camera.lookAt(target);
    camera.updateProjectionMatrix();
    section.scrollIntoView({block: 'start'});
    drawSoon();
}

/** Whether the edges of the mesh leave something to be seen between them. */
function hasRoomForLines() {
    const holder = views[0].holder, least = 30; /* pixels of a triangle */
    const scale = Math.min(holder.clientWidth / extent[0], holder.clientHeight / extent[1]);
    const room = extent[0] * extent[1] * scale * scale;
    return !picture.coarse && triangles.length / 2 <= MOST_MESH_LINES &&
        (dim === 3 || room / (triangles.length / 3) > least);
}

function connect() {
    const start = dim === 2 ? lowest : Math.max(lowest, Math.min(3, highest));
    slider.disabled = !(highest > lowest);
    slider.value = highest > lowest
        ? slider.max * Math.log(start / lowest) / Math.log(highest / lowest) : 0;
    slider.addEventListener('input', showWorse);
    const mesh = section.querySelector('input[type=checkbox]');
    mesh.checked = hasRoomForLines();
    const showLines = () => {
        for (const view of views)
            view.shape.mesh.visible = mesh.checked;
        drawSoon();
    };
    mesh.addEventListener('change', showLines);
    const shown = section.querySelector('input.features');
    const showFeatures = () => {
        for (const view of views)
            view.shape.features.visible = shown.checked;
        drawSoon();
    };
    if (shown) { /* of one state they are what the picture is for */
        shown.checked = states.length === 1;
        shown.addEventListener('change', showFeatures);
        showFeatures();
    }
    section.querySelector('button').addEventListener('click', () => { lookAtAll(); drawSoon(); });
    for (const button of document.querySelectorAll('button[data-place]')) {
        const place = button.dataset.place.split(',').map(Number);
        button.hidden = place.length !== (picture.directions ? 3 : dim) || !place.every(Number.isFinite);
        button.addEventListener('click', () => visit(place));
    }
    for (const part of section.querySelectorAll('.controls, .help, .colours'))
        part.hidden = false;
    showLines();
    showWorse();
}

function hasWebGL() {
    const context = document.createElement('canvas').getContext('webgl');
    const lose = context && context.getExtension('WEBGL_lose_context');
    if (lose)
        lose.loseContext();
    return !!context;
}

if (!hasWebGL()) {
    for (const fallback of section.querySelectorAll('.fallback'))
        fallback.textContent = 'This browser cannot draw the picture: it has no WebGL.';
    return;
}
camera.up.set(0, dim === 3 ? 0 : 1, dim === 3 ? 1 : 0);
const holders = section.querySelectorAll('.view');
states.forEach((state, i) => views.push(makeView(state, holders[i])));
makeLegend();
resize();
lookAtAll();
applyTheme();
connect();
window.addEventListener('resize', resize);
window.matchMedia('(prefers-color-scheme: dark)').addEventListener('change', applyTheme);
window.addEventListener('beforeprint', draw);
})();
