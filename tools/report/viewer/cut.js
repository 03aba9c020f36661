/* cut: the cut across the mesh: what it takes away, and what it goes through. */
const planishCut = (function () {
'use strict';

const {picture, extent, size} = planishData, {chosen} = planishChosen;
const {shades, coloured, plainMaterial} = planishColours, {select} = planishElements;

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
function turnPlane(camera) {
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

return {plane, clipping, crossing, addSquares, turnPlane, clip};
})();
