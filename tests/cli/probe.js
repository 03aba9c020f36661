/* probe: what scripts of browser.sh use to try the controls of a page; they are the bodies of functions. */
const find = query => document.querySelector(query);
const frame = () => new Promise(done => setTimeout(done, 50));

/** What the view shows. */
async function picture() {
    await frame();
    return find('canvas').toDataURL();
}

/** Set a control as a person does; returns what the view shows then. */
function set(control, value, event) {
    const of = typeof control === 'string' ? find(control) : control;
    of.value = value;
    of.dispatchEvent(new Event(event || 'input'));
    return picture();
}

function say(word, value) {
    document.body.dataset[word] = value;
}

function key(name) {
    find('canvas').dispatchEvent(new KeyboardEvent('keydown', {key: name}));
}

/** Drag over a drawing of n bins within its frame, from one bin to another, with a button of the mouse. */
function drag(svg, frame, n, from, to, button = 0) {
    const box = svg.getBoundingClientRect(), scale = box.width / svg.viewBox.baseVal.width;
    const at = bin => ({bubbles: true, button: button, clientX: box.left +
        scale * (frame[0] + (bin + 0.5) * (frame[1] - frame[0]) / n)});
    svg.dispatchEvent(new PointerEvent('pointerdown', at(from)));
    svg.dispatchEvent(new PointerEvent('pointermove', at(to)));
    svg.dispatchEvent(new PointerEvent('pointerup', at(to)));
}
