//! From what a card converted to what it measured.

use std::collections::HashMap;

use super::bytes::Value;

/// Where a scale takes its numbers from, if from no other scale.
const RAW: f64 = u32::MAX as f64;
/// Most scales of a channel, and most coefficients of one.
const MAX_SCALES: usize = 64;

/// Applies the scales that a channel's properties describe, each to the outcome of the one that it names; the error says which
/// of them is not known here.
pub(super) fn scaled(
    values: Vec<f64>,
    properties: &HashMap<String, Value>,
) -> Result<Vec<f64>, String> {
    let number = |name: &str| properties.get(name).and_then(Value::number);
    let text = |name: &str| properties.get(name).and_then(Value::text);
    let count = number("NI_Number_Of_Scales").unwrap_or(0.0);
    if count < 1.0 || text("NI_Scaling_Status") == Some("scaled") {
        return Ok(values);
    }
    if count > MAX_SCALES as f64 {
        return Err(format!("{count} scales"));
    }
    // From the last scale back to the numbers as they are stored; each step goes to an earlier one, so there are few.
    let mut steps = Vec::new();
    let mut at = count as usize - 1;
    loop {
        let of = |name: &str| number(&format!("NI_Scale[{at}]_{name}"));
        let kind = text(&format!("NI_Scale[{at}]_Scale_Type")).unwrap_or("");
        let (coefficients, source) = match kind {
            "Linear" => {
                let line = of("Linear_Y_Intercept").zip(of("Linear_Slope"));
                let (zero, slope) = line.ok_or("a linear scale without its slope")?;
                (vec![zero, slope], of("Linear_Input_Source"))
            }
            "Polynomial" => {
                let count =
                    of("Polynomial_Coefficients_Size").unwrap_or(4.0).min(MAX_SCALES as f64);
                let one = |index| of(&format!("Polynomial_Coefficients[{index}]"));
                let all: Option<Vec<f64>> = (0..count as usize).map(one).collect();
                let all = all.ok_or("a polynomial scale without its coefficients")?;
                (all, of("Polynomial_Input_Source"))
            }
            other => return Err(format!("a scale of type `{other}` is not read; export as CSV")),
        };
        steps.push(coefficients);
        match source.unwrap_or(RAW) {
            RAW => break,
            source if source >= 0.0 && source < at as f64 => at = source as usize,
            source => return Err(format!("scale {at} takes its numbers from scale {source}")),
        }
    }
    let polynomial = |value: f64, coefficients: &Vec<f64>| {
        coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * value + coefficient)
    };
    let all = |value| steps.iter().rev().fold(value, polynomial);
    Ok(values.into_iter().map(all).collect())
}
