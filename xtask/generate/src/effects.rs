//! The pages of the library of effects, from its own declarations.

use miette::{Context, IntoDiagnostic};
use palpate::files::write_whole;
use palpate::summary::effect_pages;

use crate::workspace;

/// Writes every page of docs/effects/.
pub fn write_all() -> miette::Result<()> {
    let folder = workspace().join("docs/effects");
    std::fs::create_dir_all(&folder).into_diagnostic()?;
    println!("writing {}", folder.display());
    for (name, content) in effect_pages().into_diagnostic()? {
        write_whole(&folder.join(&name), |file| file.write_all(content.as_bytes()))
            .into_diagnostic()
            .wrap_err(name)?;
    }
    Ok(())
}
