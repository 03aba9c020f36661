/* data: the picture of the mesh (picture.c), unpacked: places, elements, and the measures that colour
 * them. */
const planishData = (function () {
'use strict';

const source = document.getElementById('picture-data');

/* From good to bad, told apart by lightness, too. */
const COLOURS = ['#e6eef6', '#bcd5ea', '#86b6da', '#fde6a9', '#fdbb63', '#f5853f', '#dd3d2d', '#8f0d1d'];
const INVERTED = '#d600c8';
const NOTHING = 255;

const picture = JSON.parse(source.textContent);
source.textContent = '';
const dim = picture.dim;
const extent = [0, 1, 2].map(d => picture.high[d] - picture.low[d]);
const size = Math.max(...extent) > 0 ? Math.max(...extent) : 1;

function bytesOf(base64) {
    if (Uint8Array.fromBase64) /* newer browsers */
        return Uint8Array.fromBase64(base64);
    const text = atob(base64), bytes = new Uint8Array(text.length);
    for (let i = 0; i < text.length; i++)
        bytes[i] = text.charCodeAt(i);
    return bytes;
}

function numbersOf(base64, bits) {
    const bytes = bytesOf(base64);
    return bits === 16 ? new Uint16Array(bytes.buffer) : new Uint32Array(bytes.buffer);
}

/** Places of points, three numbers each; the box is around 0 and its longest side is 1. */
function placesOf(base64) {
    const from = numbersOf(base64, 16), places = threeOf(from);
    for (let d = 0; d < dim; d++) {
        const side = extent[d] / size;
        for (let at = d; at < places.length; at += 3)
            places[at] = (places[at] / 65535 - 0.5) * side;
    }
    return places;
}

/** Three numbers for each point, of which from has as many as the mesh has dimensions. */
function threeOf(from) {
    const places = new Float32Array(from.length / dim * 3);
    for (let d = 0; d < dim; d++)
        for (let i = d, at = d; i < from.length; i += dim, at += 3)
            places[at] = from[i];
    return places;
}

/** Elements: corners has three numbers for each corner, first[i] is the first corner of element i. */
function elements(sizes, corners, codes) {
    const first = new Uint32Array(sizes.length + 1);
    for (let i = 0; i < sizes.length; i++)
        first[i + 1] = first[i] + sizes[i];
    return {n: sizes.length, sizes: sizes, first: first, corners: corners, codes: codes};
}

/** The worst elements of a state. */
function badOf(state) {
    const ratios = new Float32Array(bytesOf(state.bad_ratios).buffer);
    const sizes = state.sizes ? bytesOf(state.sizes)
        : new Uint8Array(ratios.length).fill(dim + 1);
    const corners = state.places !== undefined ? placesOf(state.places)
        : threeOf(new Float32Array(bytesOf(state.corners).buffer));
    const bad = elements(sizes, corners, bytesOf(state.bad_codes));
    bad.ratios = ratios;
    return bad;
}

/** Elements of a set, the worst first by the codes of their ratios, with these. */
function worstFirst(set) {
    const {codes, sizes, n} = set, rank = code => code === 0 ? picture.codes + 1 : code;
    const order = Uint32Array.from(sizes.keys()).sort((i, j) => rank(codes[j]) - rank(codes[i]) || i - j);
    const sorted = elements(Uint8Array.from(order, i => sizes[i]), new Float32Array(set.corners.length),
        new Uint8Array(codes.length));
    order.forEach((i, k) => {
        sorted.corners.set(set.corners.subarray(3 * set.first[i], 3 * set.first[i + 1]), 3 * sorted.first[k]);
        for (let m = 0; m < measures.length; m++)
            sorted.codes[m * n + k] = codes[m * n + i];
    });
    sorted.ratios = Float32Array.from(order, i => measures[0].value[codes[i]]);
    return sorted;
}

/** The elements inside a state, or a sample of them. */
function insideOf(state) {
    const points = placesOf(state.inside), codes = bytesOf(state.inside_codes);
    const n = codes.length / picture.measures.length;
    const sizes = picture.inside_sizes ? bytesOf(picture.inside_sizes) : new Uint8Array(n).fill(4);
    const numbers = numbersOf(picture.inside_corners, picture.inside_bits);
    const corners = new Float32Array(numbers.length * 3);
    for (let i = 0; i < numbers.length; i++)
        for (let d = 0; d < 3; d++)
            corners[3 * i + d] = points[3 * numbers[i] + d];
    return elements(sizes, corners, codes);
}

function stateOf(state, first) {
    const inside = state.inside !== undefined ? insideOf(state) : null;
    return {
        name: state.name,
        sweep: state.sweep, /* of a step between before and after */
        points: state.points ? placesOf(state.points) : first.points,
        codes: state.codes ? bytesOf(state.codes) : null, /* of triangles */
        bad: state.bad_codes !== undefined ? badOf(state) : worstFirst(inside),
        inside: inside,
        cubes: state.cubes ? bytesOf(state.cubes) : null,
        inverted: state.inverted
    };
}

/** A measure with the value, class and colour of each code. */
function measureOf(measure) {
    const edges = measure.edges, n = edges.length - 1, codes = Math.floor(picture.codes / n);
    const classOf = value => {
        const i = measure.limits.findIndex(
            limit => measure.more_is_better ? value >= limit : value <= limit);
        return i < 0 ? COLOURS.length - 1 : i;
    };
    const colour = [INVERTED], value = [0];
    for (let code = 1; code <= n * codes; code++) {
        const bin = Math.floor((code - 1) / codes), low = edges[bin], high = edges[bin + 1];
        const place = ((code - 1) % codes + 0.5) / codes;
        value.push(high === null ? low / (1 - place) : low + place * (high - low));
        colour.push(COLOURS[classOf(value[code])]);
    }
    return Object.assign({colour: colour, value: value, bins: n,
        range: (from, to) => [1 + from * codes, to >= n ? picture.codes : to * codes]}, measure);
}

const measures = picture.measures.map(measureOf), states = [];
for (const state of picture.states)
    states.push(stateOf(state, states[0]));
const steps = (picture.steps || []).map(step => stateOf(step, states[0]));
return {
    picture: picture, dim: dim, extent: extent, size: size, states: states, steps: steps,
    isFlat: dim === 2 || picture.flat === true, /* all elements are drawn, in colours */
    isComplete: picture.stride === 1,           /* all elements inside are known */
    COLOURS: COLOURS, INVERTED: INVERTED, NOTHING: NOTHING,
    measures: measures,
    triangles: numbersOf(picture.triangles, picture.index_bits),
    sides: picture.sides ? bytesOf(picture.sides) : null, /* bit j: side j is an edge */
    features: picture.features !== undefined ? numbersOf(picture.features, picture.index_bits) : null,
    corners: picture.corners !== undefined ? numbersOf(picture.corners, picture.index_bits) : null
};
})();
