/* shape: all that is drawn of a state whatever is chosen. */
const planishShape = (function () {
'use strict';

const {dim, isFlat, measures, triangles, features, corners} = planishData;
const {themeColour} = planishPage, {chosen, slider, limit, isBrushed} = planishChosen;
const {shades, coloured, shadedMaterial, plainMaterial} = planishColours;
const {trianglePlaces, findPatches} = planishSurface;
const CURVE = '#c2410c', CORNER = '#b91c1c';
const PATCHES = ['#4477aa', '#66ccee', '#228833', '#ccbb44', '#ee6677', '#aa3377', '#999933', '#777777'];

const attributes = new Map(); /* of points, which many geometries have in common */

function attributeOf(points) {
    if (!attributes.has(points))
        attributes.set(points, new THREE.BufferAttribute(points, 3));
    return attributes.get(points);
}

function lines(points, pairs, opacity) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', attributeOf(points));
    geometry.setIndex(new THREE.BufferAttribute(pairs, 1));
    return new THREE.LineSegments(geometry,
        new THREE.LineBasicMaterial({transparent: opacity < 1, opacity: opacity}));
}

/** The features of the surface of a state: patches in colours, curves, corners. */
function makeFeatures(state) {
    const group = new THREE.Group(), patch = findPatches();
    const colours = new Float32Array(triangles.length * 3), colour = new THREE.Color();
    for (let i = 0; i < triangles.length; i++)
        colour.set(PATCHES[patch[Math.floor(i / 3)] % PATCHES.length]).toArray(colours, 3 * i);
    const skin = new THREE.Mesh(coloured(trianglePlaces(state.points), colours),
        Object.assign(shadedMaterial(), {transparent: true, depthWrite: false, opacity: 0.5}));
    const curves = lines(state.points, features, 1), dots = new THREE.BufferGeometry();
    curves.material.color.set(CURVE);
    dots.setAttribute('position', attributeOf(state.points));
    dots.setIndex(new THREE.BufferAttribute(corners, 1));
    skin.renderOrder = -1;
    group.add(skin, curves, new THREE.Points(dots,
        new THREE.PointsMaterial({size: 6, sizeAttenuation: false, color: CORNER})));
    return group;
}

/** The surface of solid elements, which can be looked into: its sides behind, and before, these. */
function makeSkins(points) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', attributeOf(points));
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
    shape.mesh = lines(state.points, edges.all, isFlat ? 0.45 : 0.15);
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

/** Bring a shape to the points of another state. */
function movePoints(shape, points) {
    shape.group.traverse(object => {
        const geometry = object.geometry;
        if (geometry && (geometry.index || !object.isMesh)) {
            geometry.setAttribute('position', attributeOf(points));
        } else if (geometry) { /* triangles that share no corners */
            geometry.attributes.position.array.set(trianglePlaces(points));
            geometry.attributes.position.needsUpdate = true;
        }
    });
}

/** Colour the triangles of a flat mesh: those that are not chosen are pale. */
function paintFacets(layer) {
    const colours = layer.shape.facets.geometry.attributes.color, array = colours.array;
    const paper = themeColour('--panel').toArray(), m = chosen.measure, rgb = shades[m];
    const n = triangles.length / 3, codes = layer.state.codes, value = limit();
    const hasLimit = slider.value > 0;
    for (let i = 0; i < n; i++) {
        const code = codes[m * n + i], isPale = chosen.brush
            ? !isBrushed(codes[chosen.brush.measure * n + i])
            : hasLimit && !(measures[0].value[codes[i]] > value) && codes[i] > 0;
        for (let j = 0; j < 9; j++)
            array[9 * i + j] = rgb[3 * code + j % 3] * (isPale ? 0.15 : 1) +
                (isPale ? 0.85 * paper[j % 3] : 0);
    }
    colours.needsUpdate = true;
}

return {makeShape, movePoints, paintFacets};
})();
