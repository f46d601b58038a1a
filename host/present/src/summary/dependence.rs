//! What a residual depends on, drawn.

use palpate_diagnose::criticism::dependence::{Bin, Dependence};
use palpate_report::number::percent;
use palpate_report::{Axis, Colour, Plot, Series};

/// All means of all quantities with their errors lie within this.
pub fn scale<'d>(dependences: impl IntoIterator<Item = &'d Dependence>) -> f64 {
    let bins = dependences.into_iter().flat_map(|dependence| &dependence.bins);
    1.05 * bins.map(|bin| bin.mean.abs() + bin.standard_error).fold(0.0, f64::max)
}

/// The mean residual over one quantity, of a signal of this unit, from minus to plus `most`.
pub fn dependence_plot(dependence: &Dependence, unit: &str, most: f64) -> Plot {
    let covariate = dependence.covariate;
    let column =
        |value: fn(&Bin) -> f64| -> Vec<f64> { dependence.bins.iter().map(value).collect() };
    let mut means = Axis::new("mean residual", unit);
    // A law that is exact leaves nothing.
    if most > 0.0 && most.is_finite() {
        means = means.range(-most, most);
    }
    let explained = percent(dependence.explained, 2);
    let (at, mean) = (column(|bin| bin.at), column(|bin| bin.mean));
    Plot::new(
        format!(
            "Residual against {}: {explained}, p = {:.3}",
            covariate.name(),
            dependence.p_value
        ),
        Axis::new(covariate.name(), covariate.unit(unit)),
        means,
    )
    .summary(format!(
        "Mean residual in {} bins of the {}, which explain {explained}",
        dependence.bins.len(),
        covariate.name(),
    ))
    .series(
        Series::error_bars("mean residual", at, mean, column(|bin| bin.standard_error))
            .colour(Colour::RESIDUAL),
    )
    .level(0.0, "")
    .height(170.0)
}
