/* surface: the triangles that are drawn: their edges, creases and patches. */
const planishSurface = (function () {
'use strict';

const {dim, triangles, sides, features} = planishData;
const CREASE = Math.cos(Math.PI / 7); /* sharper edges of the surface are drawn */

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

/** The corners of all triangles, three numbers each. */
function trianglePlaces(points) {
    const places = new Float32Array(triangles.length * 3);
    for (let i = 0; i < triangles.length; i++)
        for (let d = 0; d < 3; d++)
            places[3 * i + d] = points[3 * triangles[i] + d];
    return places;
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

return {findEdges, trianglePlaces, findPatches};
})();
