/* main: draws the picture of the mesh in the page, with three.js: the surface and elements inside it, or
 * the triangles of a flat mesh. One view shows the states before and after, on both sides of a divider.
 * Without WebGL the still pictures stay. */
(function () {
'use strict';

const {section, part} = planishPage, {lookAtAll, fitCamera} = planishCamera;
const {holder, makeLayers, makeCanvas, resize} = planishView, {applyTheme, makeLegend} = planishContent;
const controls = planishControls;

if (!makeCanvas()) {
    part('fallback').textContent = 'This browser has no WebGL: the picture is a still one.';
    return;
}
part('fallback').remove();
makeLayers();
for (const hidden of section.querySelectorAll(
    '.controls, .help, .colours, .on-view, figcaption'))
    hidden.hidden = false;
resize();
fitCamera(holder.clientWidth, holder.clientHeight);
lookAtAll();
controls.connectSlider();
controls.connectMeasure();
controls.connectCut();
controls.connectDivider();
planishHistograms.connectHistograms();
planishVisit.connectButtons();
controls.connectWhole();
planishPaper.connectPrint();
makeLegend();
applyTheme();
controls.connectBoxes();
planishAnimation.connectPlay();
window.addEventListener('resize', resize);
window.matchMedia('(prefers-color-scheme: dark)').addEventListener('change', applyTheme);
})();
