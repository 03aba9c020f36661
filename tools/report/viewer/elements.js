/* elements: elements of a set: which are chosen, their places, and how they are drawn. */
const planishElements = (function () {
'use strict';

const {dim, isFlat} = planishData, {chosen, isBrushed} = planishChosen;
const {shades, coloured, shadedMaterial, plainMaterial} = planishColours;

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
    const dots = new THREE.Points(coloured(places, colours), new THREE.PointsMaterial(
        {size: 4, sizeAttenuation: false, vertexColors: THREE.VertexColors}));
    dots.position.z = dim === 2 ? 0.003 : 0; /* above elements and lines */
    return dots;
}

/** Elements of a set: solids, their edges, and dots if asked for. */
function addElements(group, set, list, hasDots) {
    if (!list.length)
        return;
    const solids = new THREE.Mesh(gather(set, list, FACES), dim === 3 ? shadedMaterial() : plainMaterial());
    Object.assign(solids.material, {polygonOffset: dim === 3, polygonOffsetFactor: 0.5,
        polygonOffsetUnits: 1});
    group.add(solids);
    if (!isFlat) /* those of a flat mesh are among its mesh lines */
        group.add(new THREE.LineSegments(gather(set, list, EDGES),
            new THREE.LineBasicMaterial({color: 0x222222})));
    else if (dim === 2)
        solids.position.z = 0.001;
    if (hasDots)
        group.add(makeDots(set, list));
}

/** The elements of a set for which test(i) holds. */
function select(set, test) {
    const list = [];
    for (let i = 0; i < set.n; i++)
        if (test(i))
            list.push(i);
    return list;
}

/** The chosen elements of a set by the bins of the histogram. */
function brushed(set) {
    return select(set, i => isBrushed(set.codes[chosen.brush.measure * set.n + i]));
}

return {middleOf, makeDots, addElements, select, brushed};
})();
