/* colours: colours of codes, and what is drawn with them. */
const planishColours = (function () {
'use strict';

const {measures} = planishData;

/** Red, green and blue of every code of a measure. */
const shades = measures.map(measure => {
    const rgb = new Float32Array(3 * 256), colour = new THREE.Color();
    measure.colour.forEach((text, code) => colour.set(text).toArray(rgb, 3 * code));
    return rgb;
});

/** A geometry of places with a colour each. */
function coloured(places, colours) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(places, 3));
    geometry.setAttribute('color', new THREE.BufferAttribute(colours, 3));
    return geometry;
}

function shadedMaterial() {
    return new THREE.MeshPhongMaterial({vertexColors: THREE.VertexColors, flatShading: true,
        shininess: 0, side: THREE.DoubleSide});
}

function plainMaterial() {
    return new THREE.MeshBasicMaterial({vertexColors: THREE.VertexColors, side: THREE.DoubleSide});
}

return {shades, coloured, shadedMaterial, plainMaterial};
})();
