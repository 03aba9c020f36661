/* visit: buttons beside the worst elements, which show these. */
const planishVisit = (function () {
'use strict';

const {picture, dim, size, states} = planishData, {section} = planishPage;
const {middleOf} = planishElements, {camera, target} = planishCamera, {drawSoon} = planishView;

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

function connectButtons() {
    for (const button of document.querySelectorAll('button[data-place]')) {
        const place = button.dataset.place.split(',').map(Number);
        button.hidden = place.length !== (picture.directions ? 3 : dim) || !place.every(Number.isFinite);
        button.addEventListener('click', () => visit(place));
    }
}

return {connectButtons};
})();
