//! Whether a law of one's own keeps what every law of the library promises.

use palpate_diagnose::promises::{Kept, Promise};
use palpate_model::StoredEffect;
use palpate_report::{Block, Column, Section, Table};

/// The promises of a law, one row each.
#[must_use]
pub fn contract_section(law: &StoredEffect, promises: &[Promise]) -> Section {
    let columns = vec![Column::text("promise"), Column::text("kept"), Column::text("because")];
    let mut table = Table::new("Promises", columns);
    for Promise { what, found } in promises {
        let (kept, why) = in_words(found);
        table = table.row([*what, kept, why]);
    }
    let expression = law.expression.clone().unwrap_or_default();
    let mut section = Section::new(law.name.clone());
    if let Some(meaning) = &law.meaning {
        section = section.paragraph(meaning.clone());
    }
    section.block(Block::Code(expression)).table(table)
}

fn in_words(found: &Kept) -> (&'static str, &str) {
    match found {
        Kept::Yes => ("yes", ""),
        Kept::No(why) => ("no", why),
        Kept::NotAsked(why) => ("not asked", why),
    }
}
