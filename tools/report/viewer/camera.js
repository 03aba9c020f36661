/* camera: from where the mesh is seen. */
const planishCamera = (function () {
'use strict';

const {dim, extent, size} = planishData;
const FIELD_OF_VIEW = 35; /* degrees */
const HALF = 0.94 * Math.tan(FIELD_OF_VIEW / 2 * Math.PI / 180); /* of the view's height, with a margin */
const BREADTH = 4 / 3; /* of a view that the whole mesh fills; in a narrower one it is smaller */

const camera = dim === 3 ? new THREE.PerspectiveCamera(FIELD_OF_VIEW, 1, 0.001, 100)
                         : new THREE.OrthographicCamera(-1, 1, 1, -1, -10, 10);
const target = new THREE.Vector3();
camera.up.set(0, dim === 3 ? 0 : 1, dim === 3 ? 1 : 0);

let broad = 0; /* half the breadth of the whole mesh, as seen from the first distance */

/** Stand where all corners of the box are just seen. */
function standBack() {
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].map(i => new THREE.Vector3(
        ...extent.map((side, d) => (i >> d & 1 ? 0.5 : -0.5) * side / size)));
    camera.position.set(0.45, -0.75, 0.48).normalize();
    camera.lookAt(target);
    const seen = corners.map(corner => corner.applyQuaternion(camera.quaternion.clone().conjugate()));
    const distance = Math.max(...seen.map(at =>
        at.z + Math.max(Math.abs(at.x) / BREADTH, Math.abs(at.y)) / HALF));
    broad = Math.max(...seen.map(at => Math.abs(at.x) / (distance - at.z)));
    camera.position.setLength(distance);
}

/** See the whole mesh. */
function lookAtAll() {
    target.set(0, 0, 0);
    camera.zoom = 1;
    if (dim === 3)
        standBack();
    else
        camera.position.set(0, 0, 1);
    camera.lookAt(target);
    camera.updateProjectionMatrix();
}

/** Fit the camera to a width and height in pixels. */
function fitCamera(width, height) {
    if (dim === 3) { /* from an element of any size to the whole mesh */
        const distance = camera.position.distanceTo(target);
        camera.aspect = width / height;
        camera.zoom = broad > 0 ? Math.min(1, camera.aspect * HALF / broad) : 1;
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

return {camera, target, lookAtAll, fitCamera, turn, pan, approach};
})();
