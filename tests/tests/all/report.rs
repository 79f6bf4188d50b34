//! report.html in a real browser: does it do what a reader expects, without an error and without
//! asking anything of the network?

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
    assert_eq!(found["faults"], serde_json::json!([]), "script errors or refused requests");
    assert_eq!(found["loaded"], serde_json::json!([]), "nothing is loaded from elsewhere");
    found
}

/// Points at, clicks and sorts as a reader does. A pixel of the screen is asked which element lies
/// there, so that an outline that cannot be reached fails.
const READER: &str = r#"async () => {
    const data = JSON.parse(document.getElementById('data').textContent);
    const rows = [...document.querySelectorAll('tbody tr')], paths = [...document.querySelectorAll('#paths path')];
    const one = (all, name) => all.filter(e => e.classList.contains(name)).map(e => Number(e.dataset.source));
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
    const found = { sources: data.rows.length, rows: rows.length, paths: paths.length, hovers: [], clicks: [] };
    for (const path of paths.slice(0, 3)) {
        const i = Number(path.dataset.source), at = reached(path);
        if (!at) { found.hovers.push(`outline ${i} cannot be reached`); continue; }
        point(path, 'pointerover', at.x, at.y);
        point(path, 'pointermove', at.x, at.y);
        const card = document.getElementById('card');
        found.hovers.push([i, one(rows, 'hover'), one(paths, 'hover'), !card.hidden && card.textContent.includes(`label${data.rows[i][0]}`)]);
        point(path, 'pointerdown', at.x, at.y);
        point(path, 'pointerup', at.x, at.y);
        path.dispatchEvent(new MouseEvent('click', { bubbles: true }));
        const box = rows[i].getBoundingClientRect(), frame = document.querySelector('.scroll').getBoundingClientRect();
        found.clicks.push([i, one(rows, 'chosen'), box.top >= frame.top && box.bottom <= frame.bottom + 1]);
    }
    const sky = document.getElementById('sky');
    sky.dispatchEvent(new PointerEvent('pointerleave'));
    found.left = [one(rows, 'hover').length, document.getElementById('card').hidden];
    const last = rows.length - 1, whole = sky.getAttribute('viewBox');
    rows[last].dispatchEvent(new PointerEvent('pointerover', { bubbles: true }));
    found.fromRow = [last, one(paths, 'hover')];
    rows[last].click();
    found.rowClick = [last, one(paths, 'chosen'), sky.getAttribute('viewBox') !== whole, reached(paths[last]) !== null];
    document.getElementById('fit').click();
    found.fit = sky.getAttribute('viewBox') === whole;
    sky.dispatchEvent(new WheelEvent('wheel', { deltaY: -1, clientX: 400, clientY: 400, cancelable: true }));
    found.wheel = Number(sky.getAttribute('viewBox').split(' ')[2]) < data.width;
    sky.dispatchEvent(new KeyboardEvent('keydown', { key: '0' }));
    found.key = sky.getAttribute('viewBox') === whole;
    const area = data.columns.findIndex(column => column.name === 'area');
    const head = document.querySelectorAll('th')[area];
    const order = () => [...document.querySelectorAll('tbody tr')].map(row => Number(row.cells[area].textContent));
    const sorted = list => list.every((value, k) => k === 0 || list[k - 1] <= value);
    head.querySelector('button').click();
    found.up = [head.getAttribute('aria-sort'), sorted(order())];
    head.querySelector('button').click();
    found.down = [head.getAttribute('aria-sort'), sorted(order().reverse())];
    const first = document.querySelector('tbody tr');
    first.focus();
    first.dispatchEvent(new KeyboardEvent('keydown', { key: 'ArrowDown', bubbles: true }));
    found.keyboard = document.activeElement === document.querySelectorAll('tbody tr')[1];
    document.activeElement.dispatchEvent(new KeyboardEvent('keydown', { key: 'Enter', bubbles: true }));
    found.enter = one(rows, 'chosen')[0] === Number(document.activeElement.dataset.source);
    const image = document.getElementById('picture').href.baseVal;
    const decoded = new Image(); decoded.src = image; await decoded.decode();
    found.image = [decoded.naturalWidth, decoded.naturalHeight];
    found.stages = document.querySelectorAll('#stages img').length;
    found.tau = document.querySelector('#histogram .limit-name').textContent;
    found.curve = document.querySelector('#convergence .curve').getAttribute('d').split('L').length;
    return found;
}"#;

#[test]
fn outlines_and_rows_point_at_each_other() {
    let folder = Folder::new("report");
    let demo = skyfront(["demo", "--quiet", "--out", &folder.file("demo")]);
    assert!(demo.status.success(), "{}", messages(&demo));
    let front = ["--preset", "paper-f160", "--quiet", "--out", &folder.file("out")];
    let run = skyfront([["segment", &folder.file("demo/sky.fits")].as_slice(), &front].concat());
    assert!(run.status.success(), "{}", messages(&run));
    let found = in_browser(&folder, &folder.path().join("out/report.html"), READER);
    let n = found["sources"].as_u64().expect("a number");
    assert!(n >= 3, "{found}");
    assert_eq!((found["rows"].as_u64(), found["paths"].as_u64()), (Some(n), Some(n)));
    for (hover, click) in
        found["hovers"].as_array().expect("hovers").iter().zip(found["clicks"].as_array().expect("clicks"))
    {
        let i = &hover[0];
        assert_eq!(hover, &serde_json::json!([i, [i], [i], true]), "an outline shows its row: {found}");
        assert_eq!(click, &serde_json::json!([i, [i], true]), "a click brings the row into view: {found}");
    }
    assert_eq!(found["hovers"].as_array().map(Vec::len), Some(3));
    assert_eq!(found["left"], serde_json::json!([0, true]));
    let last = n - 1;
    assert_eq!(found["fromRow"], serde_json::json!([last, [last]]), "a row shows its outline");
    assert_eq!(found["rowClick"], serde_json::json!([last, [last], true, true]), "a click on a row goes there");
    for what in ["fit", "wheel", "key", "keyboard", "enter"] {
        assert_eq!(found[what], true, "{what}: {found}");
    }
    assert_eq!(found["up"], serde_json::json!(["ascending", true]));
    assert_eq!(found["down"], serde_json::json!(["descending", true]));
    assert_eq!(found["image"], serde_json::json!([300, 300]));
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
    let check = READER
        .replace("document.querySelector('#convergence .curve').getAttribute('d').split('L').length", "'none'")
        .replace("return found;", "found.convergence = document.getElementById('convergence'); return found;");
    let found = in_browser(&folder, &folder.path().join("out/report.html"), &check);
    assert!(found["sources"].as_u64().is_some_and(|n| n >= 10), "{found}");
    for (hover, click) in
        found["hovers"].as_array().expect("hovers").iter().zip(found["clicks"].as_array().expect("clicks"))
    {
        let i = &hover[0];
        assert_eq!(hover, &serde_json::json!([i, [i], [i], true]), "an outline shows its row: {found}");
        assert_eq!(click, &serde_json::json!([i, [i], true]), "a click brings the row into view: {found}");
    }
    assert_eq!((&found["stages"], &found["convergence"]), (&serde_json::json!(5), &serde_json::Value::Null));
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
