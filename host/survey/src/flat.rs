//! The numbers of an answer as a list.

use serde_json::{Map, Value};

use super::row::Estimate;
use palpate_trace::units;

/// Parts of an answer that are no estimates: how they were chosen, and matrices beside them.
const BESIDE: [&str; 7] =
    ["correlation", "forms", "interval_95", "outliers", "rows", "seeds", "spread"];
/// Names of a part that say nothing beside those of what is in it.
const ONLY_HOLDS: [&str; 3] = ["parameters", "traces", "channels"];
/// How a standard error is told beside its value.
const ERROR: &str = "_standard_error";

/// A value with its standard error and unit, as answers have it.
pub(super) fn estimate(of: &str, name: &str, found: &Value) -> Option<Estimate> {
    Some(Estimate {
        of: of.into(),
        name: name.into(),
        value: found.get("value")?.as_f64()?,
        standard_error: found.get("standard_error").and_then(Value::as_f64),
        unit: found.get("unit").and_then(Value::as_str).unwrap_or_default().into(),
    })
}

/// Every number of an answer, by its name, with what it is of: `press.csv, cycle 1, point A`; a single trace is not named.
pub(super) fn estimates(answer: &Value) -> Vec<Estimate> {
    let mut found = Vec::new();
    if let Value::Object(parts) = answer {
        for (name, part) in parts.iter().filter(|(name, _)| !name.starts_with("palpate_")) {
            walk(part, "", name, &mut found);
        }
    }
    found
}

/// What is to beware of, wherever in an answer it stands.
pub(super) fn warnings(answer: &Value) -> Vec<String> {
    let mut found = Vec::new();
    gather(answer, &mut found);
    found
}

fn gather(part: &Value, found: &mut Vec<String>) {
    match part {
        Value::Object(parts) => {
            for (name, part) in parts {
                match part {
                    Value::Array(words)
                        if ["warnings", "left_out", "notes"].contains(&&name[..]) =>
                    {
                        found.extend(words.iter().filter_map(Value::as_str).map(str::to_owned));
                    }
                    // The notes on what was tried and not taken.
                    _ if name == "rows" => {}
                    other => gather(other, found),
                }
            }
        }
        Value::Array(parts) => parts.iter().for_each(|part| gather(part, found)),
        _ => {}
    }
}

fn walk(part: &Value, of: &str, name: &str, found: &mut Vec<Estimate>) {
    let own = name.rsplit('.').next().unwrap_or(name);
    match part {
        _ if BESIDE.contains(&own) => {}
        Value::Number(number) => found.extend(number.as_f64().map(|value| Estimate {
            of: of.into(),
            name: name.into(),
            value,
            standard_error: None,
            unit: unit_of(name),
        })),
        Value::Object(parts) => match estimate(of, name, part) {
            Some(estimate) => found.push(estimate),
            None => object(parts, of, name, found),
        },
        Value::Array(parts) => {
            for (index, part) in parts.iter().enumerate() {
                match part {
                    // A single trace needs no name.
                    Value::Object(_) if own == "traces" && parts.len() == 1 => {
                        walk(part, of, "", found);
                    }
                    Value::Object(_) => walk(part, &inner(of, own, parts, index), "", found),
                    _ => walk(part, of, &format!("{name}.{}", index + 1), found),
                }
            }
        }
        _ => {}
    }
}

fn object(parts: &Map<String, Value>, of: &str, name: &str, found: &mut Vec<Estimate>) {
    for (key, part) in parts {
        if key.contains(ERROR) && parts.contains_key(&key.replace(ERROR, "")) {
            continue;
        }
        let known = found.len();
        let name = match name {
            "" => key.clone(),
            holder if ONLY_HOLDS.contains(&holder) => key.clone(),
            name => format!("{name}.{key}"),
        };
        walk(part, of, &name, found);
        if let [estimate] = &mut found[known..] {
            let error = parts
                .iter()
                .find(|(other, _)| other.contains(ERROR) && other.replace(ERROR, "") == *key);
            let error = error.and_then(|(_, value)| value.as_f64());
            estimate.standard_error = estimate.standard_error.or(error);
        }
    }
}

/// What an element of a list is of: what calls it by a name of its own, or its number.
fn inner(of: &str, list: &str, all: &[Value], index: usize) -> String {
    let element = &all[index];
    let called = |name: &str| element.get(name).and_then(Value::as_str).map(str::to_owned);
    let single = list.strip_suffix('s').unwrap_or(list);
    let own = match list {
        "traces" => called("trace"),
        "channels" => called("signal"),
        "points" => called("point").map(|point| format!("point {point}")),
        "regions" => called("points").filter(|points| !points.is_empty()).or(called("region")),
        "holds" if all.iter().any(|other| other["trace"] != all[0]["trace"]) => {
            let of_trace = all[..index].iter().filter(|other| other["trace"] == element["trace"]);
            called("trace").map(|trace| format!("{trace}, hold {}", of_trace.count() + 1))
        }
        _ => None,
    };
    let own = own.unwrap_or_else(|| format!("{single} {}", index + 1));
    if of.is_empty() { own } else { format!("{of}, {own}") }
}

/// The unit that ends a name, as units are printed.
fn unit_of(name: &str) -> String {
    // Work is no column of a trace.
    if name.ends_with("_mJ") {
        return "mJ".into();
    }
    units::of_column(name).map_or(String::new(), |_| units::printed(name).into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn numbers_are_listed_with_what_they_are_of() {
        let answer = json!({
            "palpate_segment": 1,
            "traces": [{
                "trace": "a.csv",
                "force_noise_N": 0.5,
                "cycles": [
                    {"number": 1, "dissipated_mJ": 2.0, "dissipated_standard_error_mJ": 0.25,
                     "points": [{"point": "A", "force_N": 3.0}], "pull_off": null},
                ],
                "warnings": ["beware"],
            }, {"trace": "b.csv", "force_noise_N": 0.25}],
            "parameters": {"c1": {"value": 4.0, "standard_error": null, "unit": "1/s"}},
            "outliers": [{"row": 5}],
        });
        let found = estimates(&answer);
        let shown: Vec<String> = found
            .iter()
            .map(|it| {
                format!("{}|{}|{}|{:?}|{}", it.of, it.name, it.value, it.standard_error, it.unit)
            })
            .collect();
        assert_eq!(
            shown,
            [
                "|c1|4|None|1/s",
                "a.csv, cycle 1|dissipated_mJ|2|Some(0.25)|mJ",
                "a.csv, cycle 1|number|1|None|",
                "a.csv, cycle 1, point A|force_N|3|None|N",
                "a.csv|force_noise_N|0.5|None|N",
                "b.csv|force_noise_N|0.25|None|N",
            ]
        );
        assert_eq!(warnings(&answer), ["beware"]);
        let single = json!({"traces": [{"trace": "a.csv", "force_noise_N": 0.5}]});
        assert_eq!(estimates(&single)[0].of, "");
    }
}
