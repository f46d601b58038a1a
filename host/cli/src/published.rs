//! Laws of others, tried beside those of the library.

use std::path::PathBuf;

use super::Failure;
use palpate_model::Model;
use palpate_model::effects::{PublishedError, read_laws};

/// Where such laws are.
#[derive(clap::Args)]
pub struct Published {
    /// Try the laws in this file too, or in the files of this folder; may be given several times
    #[arg(long = "effects", value_name = "LAWS.toml")]
    pub files: Vec<PathBuf>,
}

impl Published {
    /// The model with these laws among its candidates.
    pub fn beside(&self, mut model: Model) -> Result<Model, Failure> {
        for path in &self.files {
            for law in read_laws(path).map_err(Failure::input)? {
                if model.candidates.iter().any(|known| known.name == law.name) {
                    let (name, path) = (law.name, path.clone());
                    return Err(Failure::input(PublishedError::Twice { name, path }));
                }
                model.candidates.push(law);
            }
        }
        Ok(model)
    }

    /// The flags that were given, to be put behind the traces of another command.
    pub fn flags(&self) -> String {
        self.files.iter().map(|path| format!(" --effects {}", path.display())).collect()
    }
}
