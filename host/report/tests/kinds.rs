//! What palpate writes is known again as its own, so that the next result may take its place.

use std::fs;

use palpate_report::{Figure, Origin, Page, Panels};
use palpate_trace::files::plan::{DRAWING, REPORT, table};

#[test]
fn what_palpate_writes_is_known_again_by_its_kind() {
    let folder = tempfile::tempdir().unwrap();
    let origin = Origin { program: "palpate 9.9.9".into(), ..Origin::default() };
    let page = Page::new("A title", "", origin).to_html();
    let drawing = Figure::from(Panels::default()).to_svg();
    for (kind, text) in
        [(&REPORT, page), (&DRAWING, drawing), (&table(&["a,b"]), "a,b\n1,2\n".into())]
    {
        let path = folder.path().join("result").with_extension(kind.endings[0]);
        fs::write(&path, &text).unwrap();
        assert!(kind.may_replace(&path), "{kind:?}: {text}");
        fs::write(&path, "anything else").unwrap();
        assert!(!kind.may_replace(&path), "{kind:?}");
    }
}
