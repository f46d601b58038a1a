//! The files of the page, part of the program.

use axum::http::{Uri, header};
use axum::response::{IntoResponse, Response};

use super::Problem;
use palpate_report::colour;

const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
const TEXT: &str = "text/plain; charset=utf-8";

/// Path, content type, content.
const FILES: &[(&str, &str, &[u8])] = &[
    ("/", HTML, include_bytes!("page/index.html")),
    ("/style.css", CSS, include_bytes!("page/style.css")),
    ("/shell.js", SCRIPT, include_bytes!("page/shell.js")),
    ("/api.js", SCRIPT, include_bytes!("page/api.js")),
    ("/command.js", SCRIPT, include_bytes!("page/command.js")),
    ("/dom.js", SCRIPT, include_bytes!("page/dom.js")),
    ("/plot.js", SCRIPT, include_bytes!("page/plot.js")),
    ("/reading.js", SCRIPT, include_bytes!("page/reading.js")),
    ("/save.js", SCRIPT, include_bytes!("page/save.js")),
    ("/settings.js", SCRIPT, include_bytes!("page/settings.js")),
    ("/symbols.js", SCRIPT, include_bytes!("page/symbols.js")),
    ("/hand.css", CSS, include_bytes!("page/hand.css")),
    ("/hand.js", SCRIPT, include_bytes!("page/hand.js")),
    ("/live.css", CSS, include_bytes!("page/live.css")),
    ("/live.js", SCRIPT, include_bytes!("page/live.js")),
    ("/live/controls.js", SCRIPT, include_bytes!("page/live/controls.js")),
    ("/live/fingertip.js", SCRIPT, include_bytes!("page/live/fingertip.js")),
    ("/live/foretold.js", SCRIPT, include_bytes!("page/live/foretold.js")),
    ("/live/follow.js", SCRIPT, include_bytes!("page/live/follow.js")),
    ("/live/signals.js", SCRIPT, include_bytes!("page/live/signals.js")),
    ("/live/stamp.js", SCRIPT, include_bytes!("page/live/stamp.js")),
    ("/live/health.js", SCRIPT, include_bytes!("page/live/health.js")),
    ("/live/window.js", SCRIPT, include_bytes!("page/live/window.js")),
    ("/live/margin.js", SCRIPT, include_bytes!("page/live/margin.js")),
    ("/device.css", CSS, include_bytes!("page/device.css")),
    ("/device.js", SCRIPT, include_bytes!("page/device.js")),
    ("/device/calibration.js", SCRIPT, include_bytes!("page/device/calibration.js")),
    ("/device/info.js", SCRIPT, include_bytes!("page/device/info.js")),
    ("/device/parts.js", SCRIPT, include_bytes!("page/device/parts.js")),
    ("/device/ports.js", SCRIPT, include_bytes!("page/device/ports.js")),
    ("/device/selftest.js", SCRIPT, include_bytes!("page/device/selftest.js")),
    ("/device/settings.js", SCRIPT, include_bytes!("page/device/settings.js")),
    ("/lab.css", CSS, include_bytes!("page/lab.css")),
    ("/lab.js", SCRIPT, include_bytes!("page/lab.js")),
    ("/lab/alltraces.js", SCRIPT, include_bytes!("page/lab/alltraces.js")),
    ("/lab/bars.js", SCRIPT, include_bytes!("page/lab/bars.js")),
    ("/lab/bench.js", SCRIPT, include_bytes!("page/lab/bench.js")),
    ("/lab/beside.js", SCRIPT, include_bytes!("page/lab/beside.js")),
    ("/lab/candidates.js", SCRIPT, include_bytes!("page/lab/candidates.js")),
    ("/lab/chart.js", SCRIPT, include_bytes!("page/lab/chart.js")),
    ("/lab/closer.js", SCRIPT, include_bytes!("page/lab/closer.js")),
    ("/lab/covariate.js", SCRIPT, include_bytes!("page/lab/covariate.js")),
    ("/lab/discovery.js", SCRIPT, include_bytes!("page/lab/discovery.js")),
    ("/lab/dropped.js", SCRIPT, include_bytes!("page/lab/dropped.js")),
    ("/lab/guide.js", SCRIPT, include_bytes!("page/lab/guide.js")),
    ("/lab/heatmap.js", SCRIPT, include_bytes!("page/lab/heatmap.js")),
    ("/lab/model.js", SCRIPT, include_bytes!("page/lab/model.js")),
    ("/lab/motion.js", SCRIPT, include_bytes!("page/lab/motion.js")),
    ("/lab/overlay.js", SCRIPT, include_bytes!("page/lab/overlay.js")),
    ("/lab/ownlaw.js", SCRIPT, include_bytes!("page/lab/ownlaw.js")),
    ("/lab/practice.js", SCRIPT, include_bytes!("page/lab/practice.js")),
    ("/lab/sparkline.js", SCRIPT, include_bytes!("page/lab/sparkline.js")),
    ("/lab/survey.js", SCRIPT, include_bytes!("page/lab/survey.js")),
    ("/uplot/uPlot.iife.min.js", SCRIPT, include_bytes!("page/uplot/uPlot.iife.min.js")),
    ("/uplot/uPlot.min.css", CSS, include_bytes!("page/uplot/uPlot.min.css")),
    ("/uplot/LICENSE", TEXT, include_bytes!("page/uplot/LICENSE")),
];

/// The file of a path.
pub async fn serve(uri: Uri) -> Response {
    let path = uri.path();
    if path == "/palette.css" {
        return ([(header::CONTENT_TYPE, CSS)], palette()).into_response();
    }
    match FILES.iter().find(|(known, ..)| *known == path) {
        Some((_, kind, content)) => ([(header::CONTENT_TYPE, *kind)], *content).into_response(),
        None => Problem::not_found("there is no such file").into_response(),
    }
}

/// The colours of the reports, as variables: light, dark, and light on paper.
fn palette() -> String {
    let (light, dark) = (colour::variables(false), colour::variables(true));
    format!(
        ":root{{color-scheme:light;{light}}}\
         @media (prefers-color-scheme:dark){{:root:not([data-theme=light]){{color-scheme:dark;{dark}}}}}\
         :root[data-theme=dark]{{color-scheme:dark;{dark}}}\
         @media print{{:root,:root:not([data-theme=light]),:root[data-theme=dark]{{color-scheme:light;{light}}}}}"
    )
}
