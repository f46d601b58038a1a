//! The name that was probably meant by one that does not exist.

/// Likeness (Jaro and Winkler's, 0 to 1) from which a name is worth asking about.
const MIN_LIKENESS: f64 = 0.8;

/// ` (did you mean X?)` where one of the known names is like the given one, else nothing.
#[must_use]
pub fn did_you_mean<'a>(given: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let given = given.to_lowercase();
    let likeness = |name: &str| strsim::jaro_winkler(&given, &name.to_lowercase());
    let nearest = known.into_iter().map(|name| (likeness(name), name));
    let nearest = nearest.max_by(|a, b| a.0.total_cmp(&b.0));
    nearest
        .filter(|(likeness, _)| *likeness >= MIN_LIKENESS)
        .map_or(String::new(), |(_, name)| format!(" (did you mean `{name}`?)"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_is_asked_about_if_it_is_near() {
        let known = ["fung", "maxwell", "kelvin-voigt", "mullins", "coulomb-friction"];
        for (given, meant) in [
            ("fnug", "fung"),
            ("Mulins", "mullins"),
            ("coulomb_friction", "coulomb-friction"),
            ("kelvin", "kelvin-voigt"),
        ] {
            assert_eq!(did_you_mean(given, known), format!(" (did you mean `{meant}`?)"));
        }
        for given in ["", "x", "set-01.csv"] {
            assert_eq!(did_you_mean(given, known), "");
        }
    }
}
