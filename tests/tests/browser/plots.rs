//! Plots of the page: zoomed in both directions, moved, and kept as a picture and as data.

use palpate_tests::browser::Browser;
use palpate_tests::server::Server;
use serde_json::Value;

use crate::opened;

/// A line from corner to corner, what was asked of it, and the share of its columns in which it is seen.
const PLOT: &str = r"
  const { plot } = await import('/plot.js');
  const root = document.body.appendChild(document.createElement('div'));
  // Where nothing of the page moves it.
  root.style = 'position: fixed; left: 0; top: 0; width: 600px; background: white';
  const x = Float64Array.from({ length: 601 }, (_, k) => k / 100);
  let asked = null;
  const drawn = plot(root, {
    x, series: [{ label: 'line', colour: 'c0', width: 3, values: x.slice() }],
    onZoom: (from, to) => { asked = [from, to]; drawn.range(from ?? 0, to ?? 6); },
  });
  drawn.range(0, 6);
  const laidOut = () => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
  await laidOut();
  const over = root.querySelector('.u-over'), place = over.getBoundingClientRect();
  const at = (across, down, more = {}) => ({ bubbles: true, cancelable: true, movementX: 1, ...more,
    clientX: place.left + across * place.width, clientY: place.top + down * place.height });
  const mouse = (kind, ...where) => over.dispatchEvent(new MouseEvent(kind, at(...where)));
  const seen = async () => {
    await laidOut();
    const canvas = drawn.canvas(), scale = canvas.width / canvas.getBoundingClientRect().width;
    const copy = new OffscreenCanvas(Math.round(scale * place.width), canvas.height).getContext('2d', { willReadFrequently: true });
    copy.drawImage(canvas, Math.round(scale * (canvas.getBoundingClientRect().left - place.left)), 0);
    const { data, width, height } = copy.getImageData(0, 0, copy.canvas.width, copy.canvas.height);
    let columns = 0;
    for (let column = 0; column < width; column++) {
      for (let row = 0; row < height; row++) {
        const [r, g, b, opaque] = data.subarray(4 * (row * width + column));
        if (opaque > 120 && Math.max(r, g, b) - Math.min(r, g, b) > 60) { columns++; break; }
      }
    }
    return columns / width;
  };
";

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn a_plot_is_zoomed_in_both_directions_and_moved_with_the_mouse() {
    let server = Server::simulated();
    let browser = opened(&server);
    let found = browser.later(&format!(
        "{PLOT}
         const found = {{ whole: await seen() }};
         over.dispatchEvent(new WheelEvent('wheel', at(0.5, 0.5, {{ ctrlKey: true, altKey: true, deltaY: -400 }})));
         found.wheel = await seen();
         mouse('dblclick', 0.5, 0.5);
         found.again = await seen();
         mouse('mousedown', 0.5, 0.25);
         mouse('mousemove', 0.5, 0.75);
         mouse('mouseup', 0.5, 0.75);
         found.high = await seen();
         mouse('dblclick', 0.5, 0.5);
         mouse('mousedown', 0.5, 0.5, {{ shiftKey: true }});
         mouse('mousemove', 0.75, 0.5);
         mouse('mouseup', 0.75, 0.5);
         found.moved = asked;
         mouse('dblclick', 0.5, 0.5);
         mouse('mousedown', 0.25, 0.5);
         mouse('mousemove', 0.75, 0.5);
         mouse('mouseup', 0.75, 0.5);
         found.wide = asked;
         return found"
    ));
    let near = |value: &Value, expected: f64| (value.as_f64().unwrap() - expected).abs() < 0.05;
    assert!(near(&found["whole"], 1.0) && near(&found["again"], 1.0), "{found}");
    // The y axis is a little longer than the line is high.
    let room = 1.16;
    assert!(near(&found["wheel"], room * (-1_f64).exp()), "{found}");
    assert!(near(&found["high"], room * 0.5), "{found}");
    assert!(near(&found["moved"][0], -1.5) && near(&found["moved"][1], 4.5), "{found}");
    assert!(near(&found["wide"][0], 1.5) && near(&found["wide"][1], 4.5), "{found}");
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// What the buttons of these selectors offer to keep: a picture, and the first line of a table.
pub(super) fn kept(browser: &Browser, picture: &str, data: &str) -> String {
    let _ = browser.script(
        "window.kept = [];
         const offer = URL.createObjectURL;
         URL.createObjectURL = (blob) => { window.kept.push(blob); return offer.call(URL, blob); };
         return 0",
    );
    browser.click(picture);
    browser.until("a picture is kept", "window.kept.length === 1");
    let shape = browser.later(
        "const { width, height } = await createImageBitmap(window.kept[0]);
         return [window.kept[0].type, width > 300 && height > 150]",
    );
    assert_eq!(shape, serde_json::json!(["image/png", true]));
    browser.click(data);
    browser.until("data are kept", "window.kept.length === 2");
    let text = browser.later("return await window.kept[1].text()");
    let text = text.as_str().unwrap();
    assert!(text.lines().count() > 100, "{text}");
    text.lines().next().unwrap().to_owned()
}
