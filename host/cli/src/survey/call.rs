//! How a survey was called, as far as its rows depend on it.

use clap::{ArgMatches, Command, CommandFactory};
use serde_json::{Map, Value};

use crate::{Arguments, Failure};

/// Options that change no row.
const BESIDE: [&str; 7] = ["data", "output", "jobs", "json", "report", "force", "verbose"];

/// Every option that rows depend on with its value, given or not, of a call of these words.
pub fn options(words: &[String]) -> Result<Map<String, Value>, Failure> {
    let mut command = Arguments::command().no_binary_name(true);
    // Options that hold for all commands are known to each once it is built.
    command.build();
    let matches = command.clone().try_get_matches_from(words).map_err(Failure::work)?;
    Ok(of(&command, &matches))
}

fn of(command: &Command, matches: &ArgMatches) -> Map<String, Value> {
    if let Some((name, inner)) = matches.subcommand()
        && let Some(command) = command.find_subcommand(name)
    {
        return of(command, inner);
    }
    let mut options = Map::new();
    for argument in command.get_arguments() {
        let id = argument.get_id().as_str();
        if BESIDE.contains(&id) || id == "help" || id == "version" {
            continue;
        }
        let Ok(Some(values)) = matches.try_get_raw(id) else { continue };
        let values: Vec<_> = values.map(|value| value.to_string_lossy()).collect();
        let name = argument.get_long().map_or(id.to_uppercase(), |long| format!("--{long}"));
        options.insert(name, values.join(",").into());
    }
    options
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_rows_depend_on_is_told_with_its_defaults_and_nothing_else() {
        let words =
            "survey fit fung lab --by finger,date -o results --jobs 3 --terms 3 --tare --json";
        let mut command = Arguments::command().no_binary_name(true);
        command.build();
        let matches = command.clone().try_get_matches_from(words.split(' ')).unwrap();
        let found = of(&command, &matches);
        for (name, value) in [
            ("LAW", "fung"),
            ("--by", "finger,date"),
            ("--terms", "3"),
            ("--signal", "force_N"),
            ("--tare", "true"),
            ("--drop-outliers", "false"),
        ] {
            assert_eq!(found.get(name), Some(&value.into()), "{name} in {found:?}");
        }
        for name in ["--jobs", "DATA", "--json", "--output", "--report", "--verbose"] {
            assert!(!found.contains_key(name), "{name} in {found:?}");
        }
    }
}
