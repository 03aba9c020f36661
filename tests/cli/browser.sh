#!/usr/bin/env bash
# Pages in a real browser: no complaint on its console, and the pictures are drawn.
. "$(dirname "$0")/common.sh"

[ -z "${PLANISH_QUICK-}" ] || { echo "left to tools/check --full: it takes a minute"; exit 77; }
browser=$(command -v chromium || command -v chromium-browser || command -v google-chrome)
[ -n "$browser" ] || { echo "no chromium here"; exit 77; }
expect_status 0 "$program" smooth "$sample" -o smooth.msh --report solid.html -q
grep -q "without three.js" solid.html && { echo "built without three.js"; exit 77; }

# browse PAGE OPTION...: opens it as a browser does; what its console says goes to console.
browse() {
    local page=$1
    shift
    timeout 120 "$browser" --headless=new --no-sandbox --user-data-dir="$work/profile" \
        --use-angle=swiftshader --enable-unsafe-swiftshader --ignore-gpu-blocklist \
        --enable-logging=stderr --virtual-time-budget=10000 "$@" "file://$work/$page" >dom 2>log
    grep "CONSOLE" log >console
}

# expect_picture PAGE TEXT...: it draws a view, and its captions say TEXT.
expect_picture() {
    local page=$1 text
    shift
    browse "$page" --dump-dom
    [ ! -s console ] || { fail "$page: the console says"; head -n 5 console; }
    [ "$(grep -o '<canvas' dom | wc -l)" -eq 1 ] || fail "$page: a view"
    for text; do
        grep -qF -e "$text" dom || fail "$page: '$text' is not in it"
    done
}

# add PAGE SCRIPT: makes probed.html, the page with a script in it, and frames as soon as they are asked for.
add() {
    sed -e 's/^<main>$/&<script>window.requestAnimationFrame = draw => setTimeout(draw, 0);<\/script>/' \
        -e '/^<\/body>$/,$d' "$1"
    echo "<script>"
    cat "$cli/probe.js"
    echo "(async () => {"
    cat "$2"
    echo "})();</script></body></html>"
} >probed.html

# probe PAGE SCRIPT WORD...: the script in the page finds that WORD... hold (data-WORD="true").
probe() {
    local page=$1 script=$2 word
    shift 2
    add "$page" "$script"
    browse probed.html --dump-dom
    [ ! -s console ] || { fail "$page: the console says"; head -n 5 console; }
    for word; do
        grep -q "<body[^>]* data-$word=\"true\"" dom || { fail "$page: $word"; grep -o '<body[^>]*>' dom; }
    done
}

python3 "$cli/make_mesh.py" 6 0.9 tangled.mesh
cp "$source_folder/tests/data/square.msh" square.msh
expect_status 0 "$program" smooth tangled.mesh -o smooth.mesh --report tangled.html -q
expect_status 0 "$program" smooth square.msh -o plane.msh --report plane.html -q
expect_status 0 "$program" quality tangled.mesh --report quality.html -q
inverted=$("$program" quality tangled.mesh | sed -n 's/^inverted elements *//p')
expect_picture solid.html "elements worse than"
expect_picture tangled.html "$inverted of them inverted"
# More inverted elements than are drawn: what is bad after that is still to be seen.
python3 "$cli/make_mesh.py" 20 0.9 large.mesh
expect_status 0 "$program" smooth large.mesh -o smooth.mesh --report large.html -q
thin=$(printf '\u202f') # between groups of three digits
expect_picture large.html "of which 4${thin}000 are drawn" "after: "
grep -q 'after: <span class="count">[0-9'"$thin"']* elements worse than 1\.[0-9]' dom || fail "no element of the result can be chosen"
expect_picture plane.html "elements worse than"
expect_picture quality.html "$inverted of them inverted"

# The controls change what is drawn.
cat >solid.js <<'END'
    const before = await set('.divider', 100), after = await set('.divider', 0);
    say('drawn', before.length > 10000);
    say('divider', before !== after);
    say('measure', await set('.measure', 1, 'change') !== after);
    say('legend', find('.colours').textContent.includes('from 50°'));
    const whole = await set('.divider', 50), cut = await set('.cut-axis', 2, 'change');
    say('cut', cut !== whole && !find('.cut-note').hidden);
    say('place', await set('.cut-place', 40) !== cut && find('.cut-text').textContent.startsWith('z = '));
    say('uncut', await set('.cut-axis', '', 'change') === whole);
    key('ArrowLeft');
    say('keys', await picture() !== whole);
END
probe solid.html solid.js drawn divider measure legend cut place uncut keys
probe large.html solid.js drawn divider legend cut place uncut keys

# Inverted elements of a plane mesh are seen though others lie over them; not those that wrap around all others.
# A grid of triangles: the node in the middle is at x, and the nodes on the right are those on the left if it is periodic.
make_grid() { # X PERIODIC
    python3 - "$@" <<'END'
import sys
x, columns = float(sys.argv[1]), 8 if sys.argv[2] == "1" else 9
print("MeshVersionFormatted 2 Dimension 2 Vertices", 9 * columns)
for j in range(9):
    for i in range(columns):
        print(x if (i, j) == (4, 4) else i, j, 0)
print("Triangles 128")
for j in range(8):
    for i in range(8):
        a, b = j * columns + i + 1, j * columns + (i + 1) % columns + 1
        print(a, b, b + columns, 1, a, b + columns, a + columns, 1)
print("End")
END
}
make_grid 7 0 >folded.mesh
make_grid 4 1 >wrapped.mesh
for mesh in folded wrapped; do
    expect_status 0 "$program" quality $mesh.mesh --report $mesh.html -q
done
cat >folded.js <<'END'
    await set('.worse', 0);
    const canvas = find('canvas'), copy = document.createElement('canvas'), context = copy.getContext('2d');
    Object.assign(copy, {width: canvas.width, height: canvas.height});
    context.drawImage(canvas, 0, 0);
    const data = context.getImageData(0, 0, copy.width, copy.height).data;
    let drawn = 0, inverted = 0; /* pixels */
    for (let i = 0; i < data.length; i += 4) {
        drawn += data[i + 3] > 0;
        inverted += data[i] > 200 && data[i + 1] < 20 && data[i + 2] > 180;
    }
    say('few', inverted > 50 && inverted < 0.01 * drawn);
    say('some', inverted > 0.01 * drawn && inverted < 0.2 * drawn);
END
for mesh in folded wrapped; do # a line of the still picture is for each run of pixels
    sed -n 's/.*<path stroke="#d600c8" d="\([^"]*\)".*/\1/p' $mesh.html | tr M '\n' | sed -n 's/.*h//p' >$mesh.runs
done
[ -s wrapped.runs ] && ! grep -q '[0-9][0-9]' wrapped.runs && grep -q '[0-9][0-9]' folded.runs ||
    fail "inverted elements of still pictures"
probe folded.html folded.js some
probe wrapped.html folded.js few

# Bins of a histogram select elements: by lists, and by dragging over its drawing.
cat >brush.js <<'END'
    const figure = find('figure[data-measure=angle_histogram]'), counts = figure.dataset.counts.split(';');
    const [from, to] = figure.querySelectorAll('select');
    const first = await set('.worse', find('.worse').value); /* drawn as often as what is compared with it */
    const caption = () => [...document.querySelectorAll('#picture .count')].pop().textContent;
    const text = n => n.toLocaleString('en').replaceAll(',', '\u202f') + ' element' + (n === 1 ? '' : 's') + ', smallest angle ';
    const sum = (i, j) => counts[counts.length - 1].split(',').slice(i, j).map(Number).reduce((a, b) => a + b);
    say('lists', await set(from, 3, 'change') !== first && caption().startsWith(text(sum(3)) + '15° to '));
    await set(to, 4, 'change');
    say('to', caption().startsWith(text(sum(3, 5)) + '15° to 25°'));
    figure.querySelector('button').click();
    say('all', await picture() === first);
    const drawing = [figure.querySelector('svg'), figure.dataset.frame.split(',').map(Number), counts[0].split(',').length];
    drag(...drawing, 5, 2, 2);
    await frame();
    say('other', from.value === '');
    drag(...drawing, 5, 2);
    await frame();
    say('drag', caption().startsWith(text(sum(2, 6)) + '10° to 30°') && from.value === '2' && to.value === '5');
END
for page in solid plane large quality; do
    probe $page.html brush.js lists to all other drag
done

# The mesh from sweep to sweep: by the slider, by the button, and by a key; without motion where that is wished.
expect_status 0 "$program" smooth tangled.mesh -o smooth.mesh --history 6 --report played.html -q
expect_status 0 "$program" smooth square.msh -o plane.msh --tolerance 1e-7 --history 6 --report played_plane.html -q
expect_status 0 "$program" smooth large.mesh -o smooth.mesh --max-sweeps 6 --history 6 --report played_large.html -q
cat >play.js <<'END'
    const text = find('.step-text'), button = find('.play'), slider = find('.step');
    const caption = () => [...document.querySelectorAll('#picture .count')].pop().parentNode.textContent;
    say('last', text.textContent === 'after' && button.textContent === 'play' && slider.value === slider.max);
    await set('.worse', 0); /* of all elements some always differ */
    const after = await set('.divider', 0), step = await set(slider, 1), name = text.textContent;
    say('step', step !== after && /^sweep \d+ of \d+$/.test(name) && find('.right').textContent === name);
    say('caption', caption().startsWith(name + ': '));
    if (find('.cut-axis')) {
        await set('.cut-axis', 2, 'change');
        await set('.cut-axis', '', 'change');
    }
    say('uncut', await picture() === step);
    say('before', await set(slider, 0) !== step && text.textContent === 'before');
    say('back', await set(slider, slider.max) === after && caption().startsWith('after: '));
    await set('.divider', 70);
    button.click();
    say('plays', button.textContent === 'pause' && slider.value === '0' && find('.divider').value === '0');
    const seen = new Set();
    for (let i = 0; i < 150 && button.textContent === 'pause'; i++) {
        seen.add(text.textContent);
        await frame();
    }
    seen.add(text.textContent);
    say('ends', seen.size === Number(slider.max) + 1 && text.textContent === 'after' && await picture() === after);
    key(' ');
    const isPlaying = button.textContent === 'pause';
    button.click();
    say('pauses', isPlaying && button.textContent === 'play' && slider.value === '0');
END
for page in played played_plane played_large; do
    probe $page.html play.js last step caption uncut before back plays ends pauses
done
cat >still.js <<'END'
    const button = find('.play'), slider = find('.step');
    const name = button.textContent;
    button.click();
    const first = slider.value;
    await new Promise(done => setTimeout(done, 2000));
    const rested = slider.value;
    button.click();
    say('still', name === 'next state' && first === '0' && rested === '0' && slider.value === '1');
END
add played.html still.js
browse probed.html --force-prefers-reduced-motion --dump-dom
grep -q 'data-still="true"' dom || fail "played.html without motion"
# The slider begins where something is seen, also of a mesh without bad elements.
python3 "$cli/make_mesh.py" 6 0.1 good.mesh
expect_status 0 "$program" quality good.mesh --report good.html -q
cat >start.js <<'END'
    await frame();
    say('good', planishData.states[0].bad.ratios[0] < 3);
    say('start', /^[1-9].* elements worse than [12]\./.test(find('#picture .count').textContent));
END
probe good.html start.js good start

# On paper both states stand beside one another, in a copy that is there for that time.
cat >paper.js <<'END'
    await frame();
    window.dispatchEvent(new Event('beforeprint'));
    window.dispatchEvent(new Event('beforeprint'));
    say('one', document.querySelectorAll('.view .paper').length === 1);
    const paper = find('.view .paper'), width = paper ? paper.width : 0;
    const data = paper ? paper.getContext('2d').getImageData(0, 0, width, paper.height).data : [];
    const drawn = [0, 0]; /* pixels of each half */
    for (let i = 0; i < data.length; i += 4)
        drawn[Math.floor(2 * (i / 4 % width) / width)] += data[i + 3] > 0;
    say('paper', drawn.every(n => n > 10000));
    window.dispatchEvent(new Event('afterprint'));
    say('gone', !find('.view .paper') && !document.querySelector('.apart').checked);
END
probe solid.html paper.js one paper gone
probe plane.html paper.js one paper gone

# Tables fit a window and a phone; so does the page.
cat >narrow.js <<'END'
    for (const details of document.querySelectorAll('details'))
        details.open = true;
    await frame();
    const tables = [...document.querySelectorAll('.scroll')].filter(t => t.scrollWidth > t.clientWidth);
    parent.postMessage(tables.map(t => t.textContent.slice(0, 40)).join() ||
        String(document.documentElement.scrollWidth <= innerWidth), '*');
END
for page in solid plane tangled played; do
    add $page.html narrow.js
    for width in 390 1280; do
        echo "<body><iframe src=probed.html width=$width height=900></iframe><script>
            addEventListener('message', e => { document.body.dataset.fits = e.data; });</script></body>" >frame.html
        browse frame.html --dump-dom
        grep -q 'data-fits="true"' dom || fail "$page.html at $width pixels: $(grep -o 'data-fits="[^"]*"' dom)"
    done
done

# Without WebGL there are still pictures.
sed "s/getContext('webgl',/getContext('none',/" tangled.html >without.html
browse without.html --dump-dom
[ ! -s console ] && grep -q "has no WebGL" dom && ! grep -q '<canvas' dom || fail "without WebGL that should be said"
[ "$(grep -c 'class="still"' dom)" -eq 2 ] && grep -q 'stroke="#d600c8"' dom || fail "still pictures with inverted elements"
finish
