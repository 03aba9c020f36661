/* surface: the triangles that are drawn: their edges, creases and patches. */
const planishSurface = (function () {
'use strict';

const {dim, states, triangles, sides, features} = planishData;
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
        const z = u[0] * v[1] - u[1] * v[0], length = Math.sqrt(x * x + y * y + z * z) || 1;
        normals[i] = x / length;
        normals[i + 1] = y / length;
        normals[i + 2] = z / length;
    }
    return normals;
}

/** Number the edges between points: of has that of each side of the triangles, from one corner to the next;
 *  find returns that of two points, or -1. */
function numberEdges() {
    const first = new Int32Array(states[0].points.length / 3).fill(-1), next = new Int32Array(triangles.length);
    const high = new Uint32Array(triangles.length), of = new Uint32Array(triangles.length);
    let n = 0;
    const find = (a, b) => {
        const to = Math.max(a, b);
        let edge = first[Math.min(a, b)];
        while (edge >= 0 && high[edge] !== to)
            edge = next[edge];
        return edge;
    };
    for (let k = 0; k < triangles.length; k++) {
        const a = triangles[k], b = triangles[k % 3 === 2 ? k - 2 : k + 1], edge = find(a, b);
        of[k] = edge < 0 ? n : edge;
        if (edge < 0) {
            high[n] = Math.max(a, b);
            next[n] = first[Math.min(a, b)];
            first[Math.min(a, b)] = n++;
        }
    }
    return {n: n, of: of, find: find};
}

const edges = numberEdges();

/** Edges of the surface as pairs of points: all, and those where it has a crease or ends. The diagonals
 *  of quadrilaterals are none. */
function findEdges(points) {
    const normals = dim === 3 ? normalsOf(points) : null;
    const owner = new Int32Array(edges.n).fill(-1), isSharp = new Uint8Array(edges.n).fill(1);
    const all = [], sharp = [];
    for (let k = 0; k < triangles.length; k++) {
        const i = k - k % 3, edge = edges.of[k], j = owner[edge];
        if (sides && !(sides[i / 3] >> k % 3 & 1))
            continue;
        if (j < 0)
            owner[edge] = i;
        else
            isSharp[edge] = dim === 3 && Math.abs(normals[j] * normals[i] +
                normals[j + 1] * normals[i + 1] + normals[j + 2] * normals[i + 2]) < CREASE;
        if (j < 0)
            all.push(k);
    }
    for (const k of all)
        if (isSharp[edges.of[k]])
            sharp.push(k);
    return {all: pairsOf(all), sharp: pairsOf(sharp)};
}

/** The points at both ends of the listed sides. */
function pairsOf(list) {
    const pairs = new Uint32Array(2 * list.length);
    let at = 0;
    for (const k of list) {
        pairs[at++] = triangles[k];
        pairs[at++] = triangles[k % 3 === 2 ? k - 2 : k + 1];
    }
    return pairs;
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
function findPatches() {
    const parent = Int32Array.from({length: triangles.length / 3}, (_, i) => i);
    const rootOf = i => {
        while (parent[i] !== i)
            i = parent[i] = parent[parent[i]];
        return i;
    };
    const isFeature = new Uint8Array(edges.n), known = new Int32Array(edges.n).fill(-1), numbers = new Map();
    for (let i = 0; i < features.length; i += 2) {
        const edge = edges.find(features[i], features[i + 1]);
        if (edge >= 0)
            isFeature[edge] = 1;
    }
    edges.of.forEach((edge, k) => {
        const i = Math.floor(k / 3);
        if (isFeature[edge])
            return;
        if (known[edge] >= 0)
            parent[rootOf(i)] = rootOf(known[edge]);
        else
            known[edge] = i;
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
