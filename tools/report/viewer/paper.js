/* paper: the picture in print: both states beside one another. */
const planishPaper = (function () {
'use strict';

const {dim, extent} = planishData, {chosen} = planishChosen;
const {holder, layers, drawOnce, resize} = planishView;
const WIDTH = 1600, HEIGHT = 640; /* pixels, at most */

/** Copy the picture: browsers print what a canvas of WebGL showed last, not what was drawn for them. */
function makeCopy() {
    const copy = document.createElement('canvas'), context = copy.getContext('2d'), n = layers.length;
    copy.className = 'paper';
    copy.width = WIDTH;
    copy.height = dim === 2 && extent[0] > 0
        ? Math.max(150, Math.min(HEIGHT, Math.round(1.1 * WIDTH / n * extent[1] / extent[0]))) : HEIGHT;
    context.drawImage(drawOnce(copy.width, copy.height), 0, 0);
    if (n > 1)
        context.fillRect(WIDTH / 2 - 1, 0, 2, copy.height);
    return copy;
}

function connectPrint() {
    let copy = null;
    const removeCopy = () => copy && copy.remove();
    window.addEventListener('beforeprint', () => {
        const isApart = chosen.apart;
        chosen.apart = layers.length > 1;
        removeCopy(); /* a browser may ask twice */
        copy = makeCopy();
        holder.append(copy);
        chosen.apart = isApart;
        resize();
    });
    window.addEventListener('afterprint', removeCopy);
}

return {connectPrint};
})();
