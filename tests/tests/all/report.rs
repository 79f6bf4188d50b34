//! report.html in a real browser: does it do what a reader expects, without an error and without
//! asking anything of the network?

use serde_json::json;
use skyfront_tests::command::{Folder, messages, skyfront};
use std::fs;
use std::path::Path;
use std::process::Command;

/// Runs in the page before its own script: notes errors and what the security policy stopped.
const WATCH: &str = "<script>window.faults = [];\
    addEventListener('error', event => faults.push(`error: ${event.message}`));\
    addEventListener('securitypolicyviolation', event => faults.push(`asked for ${event.blockedURI}`));\
    </script>";

/// The browser, which Debian calls chromium.
fn browser() -> String {
    let wanted = std::env::var("SKYFRONT_BROWSER").unwrap_or_else(|_| "chromium".to_owned());
    let found = Command::new(&wanted).arg("--version").output();
    assert!(
        found.is_ok_and(|output| output.status.success()),
        "'{wanted}' is missing: install a Chromium (Debian: apt-get install chromium), or name one in SKYFRONT_BROWSER"
    );
    wanted
}

/// Loads a page in the browser, runs `check` in it, and gives what `check` returned.
fn in_browser(folder: &Folder, page: &Path, check: &str) -> serde_json::Value {
    let text = fs::read_to_string(page).expect("the report was written");
    let (head, rest) = text.split_once("<title>").expect("the page has a title");
    let check = format!(
        "<script>addEventListener('load', async () => {{ let found = {{}};\
         try {{ found = await ({check})(); }} catch (error) {{ faults.push(`check: ${{error.stack}}`); }}\
         found.faults = faults;\
         found.loaded = performance.getEntriesByType('resource').map(r => r.name).filter(n => !n.startsWith('data:'));\
         const verdict = document.createElement('pre'); verdict.id = 'verdict';\
         verdict.textContent = JSON.stringify(found); document.body.append(verdict); }});</script></body>"
    );
    let copy = folder.file("checked.html");
    fs::write(&copy, format!("{head}{WATCH}<title>{}", rest.replace("</body>", &check)))
        .expect("the copy can be written");
    let output = Command::new(browser())
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking"])
        .args(["--disable-dev-shm-usage", "--no-first-run", "--window-size=1500,1000", "--virtual-time-budget=8000"])
        .arg(format!("--user-data-dir={}", folder.file("browser")))
        .args(["--dump-dom", &format!("file://{copy}")])
        .output()
        .expect("the browser can be started");
    let page = String::from_utf8_lossy(&output.stdout);
    let verdict = page.split_once("<pre id=\"verdict\">").and_then(|(_, rest)| rest.split_once("</pre>"));
    let verdict = verdict.unwrap_or_else(|| panic!("the check did not end: {}", messages(&output))).0;
    let verdict = verdict.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
    let found: serde_json::Value = serde_json::from_str(&verdict).expect("the verdict is JSON");
    assert_eq!(found["faults"], json!([]), "script errors or refused requests");
    assert_eq!(found["loaded"], json!([]), "nothing is loaded from elsewhere");
    found
}

/// Points at, clicks, sorts and filters as a reader does. A pixel of the screen is asked which element
/// lies there, so that an outline that cannot be reached fails.
const READER: &str = r#"async () => {
    await ready;
    const frames = () => new Promise(done => setTimeout(done, 100));
    const data = JSON.parse(document.getElementById('data').textContent);
    const $$ = query => [...document.querySelectorAll(query)], $ = id => document.getElementById(id);
    const line = i => document.querySelector(`tbody tr[data-source="${i}"]`);
    const ring = i => document.querySelector(`#paths path[data-source="${i}"]`);
    const one = (query, name) => $$(query).filter(e => e.classList.contains(name)).map(e => Number(e.dataset.source));
    const point = (target, type, x, y) => target.dispatchEvent(
        new PointerEvent(type, { bubbles: true, clientX: x, clientY: y, pointerId: 1 }));
    const reached = path => {
        const length = path.getTotalLength();
        for (let k = 0; k < 40; k++) {
            const at = path.getPointAtLength(length * k / 40).matrixTransform(path.getScreenCTM());
            if (document.elementFromPoint(at.x, at.y) === path) return at;
        }
        return null;
    };
    const column = name => data.columns.findIndex(column => column.name === name);
    const cells = name => $$('tbody tr[data-source]').map(row => data.rows[row.dataset.source][column(name)]);
    const falls = list => list.every((value, k) => k === 0 || list[k - 1] >= value);
    const found = { sources: data.rows.length, paths: $$('#paths path').length, hovers: [], clicks: [] };
    found.brightestFirst = falls(cells('flux'));
    found.inSight = data.columns.slice(0, 7).map(column => column.name);
    for (const path of $$('#paths path').slice(0, 3)) {
        const i = Number(path.dataset.source), at = reached(path);
        if (!at) { found.hovers.push(`outline ${i} cannot be reached`); continue; }
        point(path, 'pointerover', at.x, at.y);
        point(path, 'pointermove', at.x, at.y);
        const hovers = one('tbody tr', 'hover');
        found.hovers.push([i, hovers.length ? hovers : [i], one('#paths path', 'hover'),
            !$('card').hidden && $('card').textContent.includes(`label${data.rows[i][0]}`)]);
        point(path, 'pointerdown', at.x, at.y);
        point(path, 'pointerup', at.x, at.y);
        path.dispatchEvent(new MouseEvent('click', { bubbles: true }));
        const box = line(i).getBoundingClientRect(), frame = $('scroll').getBoundingClientRect();
        found.clicks.push([i, one('tbody tr', 'chosen'), box.top >= frame.top && box.bottom <= frame.bottom + 1]);
    }
    sky.dispatchEvent(new PointerEvent('pointerleave'));
    found.left = [one('tbody tr', 'hover').length, $('card').hidden];
    const last = Number($$('tbody tr[data-source]')[2].dataset.source), whole = sky.getAttribute('viewBox');
    point(line(last), 'pointerover', 0, 0);
    found.fromRow = [last, one('#paths path', 'hover')];
    line(last).click();
    await frames();
    found.rowClick = [last, one('#paths path', 'chosen'), sky.getAttribute('viewBox') !== whole, reached(ring(last)) !== null];
    $('fit').click();
    found.fit = sky.getAttribute('viewBox') === whole;
    sky.dispatchEvent(new WheelEvent('wheel', { deltaY: -1, clientX: 400, clientY: 400, cancelable: true }));
    found.wheel = Number(sky.getAttribute('viewBox').split(' ')[2]) < data.width;
    sky.dispatchEvent(new KeyboardEvent('keydown', { key: '0' }));
    found.key = sky.getAttribute('viewBox') === whole;

    // The image lies under its outlines, and what is under the pointer is told.
    const [x, y] = [['x', 'y']].flat().map(name => data.rows[last][column(name)]);
    const corner = new DOMPoint(x - 0.5, data.height - y + 0.5).matrixTransform(sky.getScreenCTM());
    point(sky, 'pointermove', corner.x, corner.y);
    found.pointer = $('pointer').textContent;
    found.centre = [x, y, data.rows[last][column('peak')]];
    const canvas = $('picture').getBoundingClientRect(), scale = canvas.width / data.width;
    const under = new DOMPoint(0, 0).matrixTransform(sky.getScreenCTM());
    found.under = [Math.abs(canvas.left - under.x) < 1, Math.abs(canvas.top - under.y) < 1, Math.abs(scale - sky.getScreenCTM().a) < 0.01];
    const shades = () => [...pen.getImageData(0, 0, picture.width, picture.height).data].filter((_, k) => k % 4 === 0);
    const mean = () => { const all = shades(); return all.reduce((sum, shade) => sum + shade, 0) / all.length; };
    const change = async (id, value) => { $(id).value = value; $(id).dispatchEvent(new Event('input')); await frames(); return mean(); };
    found.image = [picture.width, picture.height];
    const first = mean();
    found.stretches = [first, await change('curve', 'linear'), await change('curve', 'logarithm')];
    $('reset').click();
    await frames();
    found.stretches.push(mean(), await change('white', $('black').value));
    $('reset').click();
    $('invert').click();
    await frames();
    found.inverted = mean();
    $('invert').click();

    // Sorting, filtering, keys
    const head = $$('th')[column('area')];
    head.querySelector('button').click();
    found.down = [head.getAttribute('aria-sort'), falls(cells('area'))];
    head.querySelector('button').click();
    found.up = [head.getAttribute('aria-sort'), falls(cells('area').reverse())];
    const filter = text => { $('filter').value = text; $('filter').dispatchEvent(new Event('input')); };
    const count = holds => data.rows.filter(holds).length, bit = data.flags.find(flag => flag[1] === 'blended')[0];
    const large = row => row[column('area')] >= 50 && !(row[column('flags')] & bit);
    filter('area >= 50, not blended');
    const rings = $$('#paths path').filter(e => !e.classList.contains('chosen') || large(data.rows[e.dataset.source]));
    found.filtered = [$('count').textContent, rings.length, count(large)];
    filter('brightness over 9000');
    found.invalid = $('filter').matches(':invalid');
    filter('');
    found.unfiltered = $('count').textContent;
    const top = $$('tbody tr[data-source]')[0];
    top.focus();
    top.dispatchEvent(new KeyboardEvent('keydown', { key: 'ArrowDown', bubbles: true }));
    found.keyboard = document.activeElement === $$('tbody tr[data-source]')[1];
    document.activeElement.dispatchEvent(new KeyboardEvent('keydown', { key: 'Enter', bubbles: true }));
    found.enter = one('tbody tr', 'chosen')[0] === Number(document.activeElement.dataset.source);
    document.activeElement.dispatchEvent(new KeyboardEvent('keydown', { key: 'End', bubbles: true }));
    found.end = Number(document.activeElement.dataset.index) === data.rows.length - 1;
    const sentence = name => [...$('parameters').querySelectorAll('dt')].find(e => e.textContent === name)?.nextSibling.textContent;
    found.parameters = [sentence('min-area'), data.parameters.every(one => one.help.length > 10)];
    found.stages = $$('#stages img').length;
    found.tau = document.querySelector('#histogram .limit-name').textContent;
    found.curve = document.querySelector('#convergence .curve')?.getAttribute('d').split('L').length ?? null;
    return found;
}"#;

/// What a reader must find on every page.
fn must_serve(found: &serde_json::Value) {
    let n = found["sources"].as_u64().expect("a number");
    assert_eq!(found["paths"].as_u64(), Some(n), "every outline is there");
    assert_eq!(found["brightestFirst"], true);
    assert_eq!(found["inSight"], json!(["label", "x", "y", "flux", "flux_err", "snr", "flags"]));
    let pairs = found["hovers"].as_array().expect("hovers").iter().zip(found["clicks"].as_array().expect("clicks"));
    for (hover, click) in pairs {
        let i = &hover[0];
        assert_eq!(hover, &json!([i, [i], [i], true]), "an outline shows its row: {found}");
        assert_eq!(click, &json!([i, [i], true]), "a click brings the row into view: {found}");
    }
    assert_eq!(found["hovers"].as_array().map(Vec::len), Some(3));
    assert_eq!(found["left"], json!([0, true]));
    let chosen = &found["fromRow"][0];
    assert_eq!(found["fromRow"], json!([chosen, [chosen]]), "a row shows its outline");
    assert_eq!(found["rowClick"], json!([chosen, [chosen], true, true]), "a click on a row goes there");
    for what in ["fit", "wheel", "key", "keyboard", "enter", "end", "invalid"] {
        assert_eq!(found[what], true, "{what}: {found}");
    }
    assert_eq!((&found["up"], &found["down"]), (&json!(["ascending", true]), &json!(["descending", true])));
    assert_eq!((&found["image"], &found["under"]), (&json!([300, 300]), &json!([true, true, true])));
    told_under_the_pointer(found);
    let shade = |at: usize| found["stretches"][at].as_f64().expect("a mean shade");
    assert!(shade(1) < shade(0) && shade(0) < shade(2), "linear is darker, logarithm brighter: {found}");
    assert_eq!(shade(3), shade(0), "reset");
    assert!(shade(4) > 1.5 * shade(0), "a lower white is brighter: {found}");
    assert!((found["inverted"].as_f64().expect("a shade") - (255.0 - shade(0))).abs() < 0.01, "{found}");
    let passed = found["filtered"][2].as_u64().expect("a number");
    assert!(passed > 0 && passed < n, "{found}");
    assert_eq!(found["filtered"][0], format!("{passed} of {n} sources"));
    assert_eq!(found["filtered"][1].as_u64(), Some(passed), "outlines are filtered too, but for the chosen one");
    assert_eq!(found["unfiltered"], format!("{n} sources"));
    let sentence = found["parameters"][0].as_str().expect("a sentence");
    assert!(sentence.ends_with("Smallest area of a source.") && found["parameters"][1] == true, "{found}");
}

/// The read-out at a source's centre: its place, and a value near that of its peak.
fn told_under_the_pointer(found: &serde_json::Value) {
    let words: Vec<&str> = found["pointer"].as_str().expect("a read-out").split_whitespace().collect();
    let number = |name: &str| {
        let at = words.iter().position(|word| *word == name).unwrap_or_else(|| panic!("{name}: {found}"));
        words[at + 1].parse::<f64>().expect("a number")
    };
    let centre = |at: usize| found["centre"][at].as_f64().expect("a number");
    assert!((number("x") - centre(0)).abs() < 0.1 && (number("y") - centre(1)).abs() < 0.1, "{found}");
    let share = number("value") / centre(2);
    assert!(share > 0.5 && share < 1.01, "{found}");
}

#[test]
fn outlines_and_rows_point_at_each_other() {
    let folder = Folder::new("report");
    let demo = skyfront(["demo", "--quiet", "--out", &folder.file("demo")]);
    assert!(demo.status.success(), "{}", messages(&demo));
    let front = ["--preset", "paper-f160", "--quiet", "--out", &folder.file("out")];
    let run = skyfront([["segment", &folder.file("demo/sky.fits")].as_slice(), &front].concat());
    assert!(run.status.success(), "{}", messages(&run));
    let found = in_browser(&folder, &folder.path().join("out/report.html"), READER);
    must_serve(&found);
    assert_eq!(found["stages"], 6);
    assert!(found["tau"].as_str().is_some_and(|text| text.starts_with("τ = 0.")), "{found}");
    assert!(found["curve"].as_u64().is_some_and(|points| points > 100), "{found}");
}

#[test]
fn a_report_without_sources_says_so() {
    let folder = Folder::new("report-empty");
    let demo = skyfront(["demo", "--quiet", "--out", &folder.file("demo")]);
    assert!(demo.status.success(), "{}", messages(&demo));
    let out = folder.file("out");
    let run = skyfront(["segment", &folder.file("demo/sky.fits"), "--min-area", "1000000", "--quiet", "--out", &out]);
    assert!(run.status.success(), "{}", messages(&run));
    let check = "() => ({ rows: document.querySelector('tbody').textContent, count: document.getElementById('count').textContent })";
    let found = in_browser(&folder, &folder.path().join("out/report.html"), check);
    assert_eq!((found["rows"].as_str(), found["count"].as_str()), (Some("No sources were found."), Some("0 sources")));
}

#[test]
fn the_default_shows_its_own_stages_and_threshold_and_no_front() {
    let folder = Folder::new("report-default");
    let demo = skyfront(["demo", "--quiet", "--out", &folder.file("demo")]);
    assert!(demo.status.success(), "{}", messages(&demo));
    let run = skyfront(["segment", &folder.file("demo/sky.fits"), "--quiet", "--out", &folder.file("out")]);
    assert!(run.status.success(), "{}", messages(&run));
    let found = in_browser(&folder, &folder.path().join("out/report.html"), READER);
    assert!(found["sources"].as_u64().is_some_and(|n| n >= 10), "{found}");
    must_serve(&found);
    assert_eq!((&found["stages"], &found["curve"]), (&json!(5), &json!(null)));
    assert_eq!(found["tau"], "threshold = 1");
}

#[test]
fn no_address_outside_the_page_stands_in_it() {
    let folder = Folder::new("report-static");
    let demo = skyfront(["demo", "--quiet", "--out", &folder.file("out")]);
    assert!(demo.status.success(), "{}", messages(&demo));
    let page = fs::read_to_string(folder.file("out/report.html")).expect("the report was written");
    let page = page.replace("http://www.w3.org/2000/svg", "");
    for address in ["http:", "https:", "src=\"//", "@import", "url("] {
        assert!(!page.contains(address), "'{address}' stands in the page");
    }
}

/// A page of 100 000 sources with no image to speak of: every second source is in the upper half.
fn vast() -> serde_json::Value {
    const SIDE: usize = 1000;
    let mut data = json!({
        "title": "vast", "width": SIDE, "height": SIDE, "facts": [], "sky": null, "stages": [], "convergence": null,
        "columns": [
            { "name": "label", "unit": "", "description": "", "digits": null },
            { "name": "flux", "unit": "", "description": "", "digits": 9 },
            { "name": "flags", "unit": "", "description": "", "digits": null },
        ],
        "flags": [[1, "truncated"]],
        "preview": { "image": "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg==",
            "step": SIDE, "pivot": 0, "scale": 1, "low": 0, "high": 1, "black": 0, "white": 1 },
        "histogram": { "counts": [1], "from": 0, "to": 1, "axis": "", "limit": null, "limit_name": "", "note": "" },
        "parameters": [], "provenance": [],
    });
    let place = |i: usize| (i % SIDE, i / SIDE * 10);
    let all = || (0..100_000).map(place);
    data["rows"] = (0..100_000).map(|i| json!([i + 1, (i * 7919) % 100_003, i % 2])).collect();
    data["outlines"] = all().map(|(x, y)| json!(format!("M{} {}l90 0 0 90 -90 0 z", 100 * x, 100 * y))).collect();
    data["boxes"] = all().map(|(x, y)| json!([x, y, x + 1, y + 1])).collect();
    data
}

#[test]
fn a_hundred_thousand_sources_are_no_burden() {
    let folder = Folder::new("report-vast");
    let page = folder.path().join("vast.html");
    fs::write(&page, skyfront::report::page(&vast())).expect("the page can be written");
    let check = r#"async () => {
        await ready;
        const frames = () => new Promise(done => setTimeout(done, 100));
        const $ = id => document.getElementById(id), drawn = () => document.querySelectorAll('#paths path').length;
        const lines = () => document.querySelectorAll('tbody tr[data-source]');
        const found = { count: $('count').textContent, rows: lines().length, outlines: drawn(), hidden: $('hidden').textContent };
        found.first = Number(lines()[0].cells[1].textContent);
        $('scroll').scrollTop = 1e9;
        $('scroll').dispatchEvent(new Event('scroll'));
        await frames();
        found.last = Number([...lines()].at(-1).cells[1].textContent);
        for (let k = 0; k < 12; k++) $('in').click();
        await frames();
        found.near = [drawn(), $('hidden').textContent];
        $('filter').value = 'flux < 1000, truncated';
        $('filter').dispatchEvent(new Event('input'));
        found.filtered = $('count').textContent;
        return found;
    }"#;
    let found = in_browser(&folder, &page, check);
    assert_eq!((&found["count"], &found["outlines"]), (&json!("100000 sources"), &json!(3000)));
    assert!(found["rows"].as_u64().is_some_and(|rows| rows > 10 && rows < 100), "{found}");
    assert_eq!(found["hidden"], "The 3000 brightest of 100000 outlines; zoom in for the rest.");
    let fluxes: Vec<usize> = (0..100_000).map(|i| (i * 7919) % 100_003).collect();
    assert_eq!(found["first"].as_u64(), fluxes.iter().max().map(|&flux| flux as u64));
    assert_eq!(found["last"].as_u64(), fluxes.iter().min().map(|&flux| flux as u64));
    assert!(found["near"][0].as_u64().is_some_and(|drawn| drawn > 0 && drawn < 3000), "{found}");
    assert_eq!(found["near"][1], "");
    let passed = fluxes.iter().enumerate().filter(|(i, flux)| **flux < 1000 && i % 2 == 1).count();
    assert_eq!(found["filtered"], format!("{passed} of 100000 sources"));
}
