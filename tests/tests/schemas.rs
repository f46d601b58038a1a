//! What a program that reads an answer may rely on: `docs/schema/`, one JSON schema an answer, held to what the commands print.
//! `INSTA_UPDATE=always cargo test --workspace --test schemas` writes the schemas anew.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use palpate::answers::schemas;
use palpate_tests::lab::lab;
use palpate_tests::{follows_schema, palpate, schema_file};
use serde_json::Value;

/// Calls of every command that answers in JSON, by the schema of its answer, in the folder of [`lab`].
/// `next_motion` and `discover` hold a proposed motion and formulas to their schemas, which take longer to find.
const CALLS: &[(&str, &str)] = &[
    ("add", "add mullins model.toml traces"),
    ("afm", "afm curve.csv still.csv flat.csv --tip-radius-nm=2500"),
    ("afm", "afm stiff.csv --shape=cone --half-angle-deg=20"),
    ("afm-rough", "afm rough --trials=20"),
    ("compare", "compare model.toml traces"),
    ("convert", "convert press.csv -o converted.palpate"),
    ("convert", "convert converted.palpate traces -o all.csv"),
    ("creep", "creep held.csv --terms 1"),
    ("creep", "creep held.csv --terms 3 --cutoff 20"),
    ("decompose", "decompose traces"),
    ("diagnose", "diagnose --model few.toml few"),
    ("diagnose", "diagnose --model few.toml few --next next.csv --for v1,c2"),
    ("discover", "discover --model few.toml few"),
    ("drop", "drop mullins better.toml traces"),
    ("effects-check", "effects --check laws.toml"),
    ("effects-list", "effects"),
    ("effects-one", "effects mullins"),
    ("events", "events slip.csv"),
    ("events", "events traces"),
    ("explore", "explore --model stress.toml stress"),
    ("explore", "explore --model model.toml traces/table-3.1-row-01.csv -o top.toml"),
    ("fit", "fit fung few --terms auto"),
    ("fit", "fit latency traces/table-3.1-row-01.csv --segments 2"),
    ("fit-holds", "fit fung traces --hold-only --terms auto"),
    ("fit-holds", "fit fung --hold-only traces/table-3.1-row-01.csv"),
    ("fit-rank", "fit --all few"),
    ("fit-rank", "fit --all traces/table-3.1-row-01.csv --terms 1"),
    ("grasp-friction", "grasp friction slide.csv --contact=circle:5"),
    ("grasp-friction", "grasp friction twist.csv --contact=rectangle:30x20 --across=shear_N"),
    (
        "grasp-growth",
        "grasp growth --contact=sphere:35 --friction=0.7 --model=model.toml --force=1",
    ),
    ("grasp-margin", "grasp margin pull.csv --contact=circle:5 --friction=0.7 --model=model.toml"),
    ("grasp-margin", "grasp margin slide.csv --contact=circle:5 --friction=0.7 --tangential=0"),
    ("grasp-plan", "grasp plan finger.toml"),
    ("grasp-plan", "grasp plan hand.toml --model=model.toml --for=60 --least=largest"),
    ("grasp-surface", "grasp surface --contact=circle:5 --exponent=inf --friction=0.7 --force=2"),
    (
        "grasp-surface",
        "grasp surface --contact=ellipse:6x4 --friction=0.7 --force=2 --tangential=0.5 --moment=1",
    ),
    (
        "grasp-surface",
        "grasp surface --contact=rectangle:9x4 --friction=0.7 --force=2 --tangential=0",
    ),
    (
        "grasp-watch",
        "grasp watch --recording=press.palpate --contact=circle:5 --friction=0.7 --normal=0.001 --tangential=0.3",
    ),
    (
        "grasp-watch",
        "grasp watch --recording=press.palpate --contact=sphere:35 --friction=0.7 --normal=0.001 --model=model.toml",
    ),
    ("hide", "hide mullins --seed 7 -o hidden"),
    ("hide-open", "hide --open set"),
    ("hide-record", "hide --record traces/table-3.1-row-01.csv -o set"),
    ("markers", "markers markers.csv"),
    ("markers", "markers markers.csv --order free"),
    ("plan", "plan --noise 0.01"),
    ("plan", "plan --noise 0.01 --want v1=2"),
    ("plan", "plan --noise 0.01 --want v2=0.001"),
    ("rates", "rates runs"),
    ("rates", "rates runs/20.csv"),
    ("relaxation", "relaxation traces"),
    ("relaxation", "relaxation runs/20.csv"),
    ("segment", "segment pads"),
    ("segment", "segment traces"),
    ("sensor-frequency", "sensor frequency --count=4 --from=1"),
    ("sensor-press", "sensor press --indenter=sharp"),
    ("sensor-press", "sensor press --after=0.2 --force=0.01"),
    ("sensor-shake", "sensor shake --duration=2"),
    ("sensor-slide", "sensor slide"),
    ("sensor-slide", "sensor slide --rate=100"),
    ("sensor-slip", "sensor slip"),
    ("strain-rate", "strain-rate --modulus 2.8e4 --order free ball.csv"),
    ("strain-rate", "strain-rate --modulus 2.8e4 --simulate 8 ball.csv"),
    ("survey-population", "survey population fitted"),
    ("survey-report", "survey report segmented"),
    ("survey-report", "survey report diagnosed"),
];

/// The same of a device, which is simulated in a folder with a bench's points.
const DEVICE_CALLS: &[(&str, &str)] = &[
    ("device-calibrate", "device calibrate --points bench.csv"),
    ("device-calibrate", "device calibrate --gauge 2 --gain=0.001 --offset=-7"),
    ("device-info", "device info"),
    ("device-self-test", "device self-test"),
    ("device-set", "device set --rate 2000 --threshold touch=33 --save"),
    ("device-tare", "device tare"),
];
/// Ports that are asked who is there: that device and one without.
const LIST: (&str, &str) = ("device-list", "device list fingertip absent");
/// A recording of it, so long that something is felt: an object a second, and a last one.
const RECORD: ([&str; 2], &str) =
    (["record-second", "record"], "record -o take.palpate --mcap take.mcap --duration 5.2");

/// Answers that take long to compute: the tests of their commands hold them to their schemas.
const ELSEWHERE: &[&str] = &["dissertation"];

/// The JSON that a call prints: one answer, or one after another.
fn answers(folder: &Path, call: &str) -> Vec<Value> {
    let mut command = palpate();
    let output = command.current_dir(folder).args(call.split(' ')).arg("--json").output().unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "palpate {call}: {error}");
    let printed = serde_json::Deserializer::from_slice(&output.stdout).into_iter();
    let printed: Vec<Value> = printed.collect::<Result<_, _>>().unwrap();
    assert!(!printed.is_empty(), "palpate {call}");
    printed
}

#[test]
fn the_schemas_are_those_of_the_types() {
    let update = std::env::var("INSTA_UPDATE").is_ok_and(|how| how == "always");
    for (name, schema) in schemas() {
        let text = format!("{:#}\n", schema.as_value());
        if update {
            fs::write(schema_file(name), &text).unwrap();
        }
        let kept = fs::read_to_string(schema_file(name)).unwrap_or_default();
        assert!(kept == text, "docs/schema/{name}.json is not that of its type");
    }
}

#[test]
fn every_answer_has_a_schema_and_every_schema_a_call() {
    let calls = CALLS.iter().chain(DEVICE_CALLS).map(|(name, _)| *name);
    let called = calls.chain([LIST.0]).chain(RECORD.0).chain(ELSEWHERE.iter().copied());
    let known: BTreeSet<&str> = schemas().into_iter().map(|(name, _)| name).collect();
    assert_eq!(called.collect::<BTreeSet<_>>(), known);
}

#[test]
fn what_is_printed_follows_its_schema() {
    let lab = lab();
    for (name, call) in CALLS {
        for answer in answers(lab.path(), call) {
            follows_schema(name, &answer);
        }
    }
}

/// A simulated device in a folder, until it is dropped.
#[cfg(unix)]
struct Fingertip(std::process::Child);

#[cfg(unix)]
impl Drop for Fingertip {
    fn drop(&mut self) {
        // One that has ended on its own is as good.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[cfg(unix)]
#[test]
fn what_a_device_answers_follows_its_schema() {
    let lab = tempfile::tempdir().unwrap();
    let bench = "gauge,strain_ustrain,counts\n1,0,1000\n1,500,251010\n1,1000,500990\n3,0,-40\n3,100,-50040\n";
    fs::write(lab.path().join("bench.csv"), bench).unwrap();
    let _fingertip = Fingertip(palpate_tests::server::simulate(lab.path()));
    let ask = |call: &str| answers(lab.path(), &format!("{call} --port fingertip"));
    for (name, call) in DEVICE_CALLS {
        follows_schema(name, &ask(call)[0]);
    }
    follows_schema(LIST.0, &answers(lab.path(), LIST.1)[0]);

    let [second, last] = RECORD.0;
    let mut objects = ask(RECORD.1);
    follows_schema(last, &objects.pop().unwrap());
    assert!(!objects.is_empty(), "an object a second");
    for object in objects {
        follows_schema(second, &object);
    }
}
