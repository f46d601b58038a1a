//! Work that gives up by panicking, where that is no reason to end.

use std::cell::{Cell, RefCell};
use std::panic::{UnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

thread_local! {
    /// Whether a panic of this thread is caught and told otherwise.
    static CAUGHT: Cell<bool> = const { Cell::new(false) };
    /// What the last one said.
    static SAID: RefCell<String> = const { RefCell::new(String::new()) };
}

/// What `work` returns, or what it said where it panicked; nothing is printed then.
pub fn caught<T>(work: impl FnOnce() -> T + UnwindSafe) -> Result<T, String> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let before = take_hook();
        set_hook(Box::new(move |panic| {
            if CAUGHT.get() {
                let said = panic.payload();
                let said = said.downcast_ref::<&str>().copied();
                let said = said.or(panic.payload().downcast_ref::<String>().map(String::as_str));
                let said = said.unwrap_or("it gave up without a word");
                // The name of the file alone: where the sources lay is of no use to anybody.
                let at = panic.location().map(|at| {
                    let name = at.file().rsplit(['/', '\\']).next();
                    format!(" ({}:{})", name.unwrap_or_default(), at.line())
                });
                SAID.set(said.to_owned() + &at.unwrap_or_default());
            } else {
                before(panic);
            }
        }));
    });
    let outer = CAUGHT.replace(true);
    let result = catch_unwind(work);
    CAUGHT.set(outer);
    result.map_err(|_| SAID.take())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_told_and_the_next_work_is_done() {
        let said = caught(|| panic!("no {}", "way")).unwrap_err();
        assert!(said.starts_with("no way (") && said.contains("caught.rs"), "{said}");
        assert_eq!(caught(|| 7), Ok(7));
    }
}
