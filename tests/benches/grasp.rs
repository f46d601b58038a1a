//! A whole limit surface of 200 points, its tables included, and the margin of one load.

use criterion::{Criterion, criterion_group, criterion_main};
use palpate::grasp::{Contact, Load, PressureLaw, Shape, limit_surface, margin};
use std::hint::black_box;

const SHAPES: [(&str, Shape); 3] = [
    ("circle", Shape::Circle { radius: 5.0 }),
    ("ellipse", Shape::Ellipse { x: 6.0, y: 4.0 }),
    ("rectangle", Shape::Rectangle { length: 42.22, width: 26.38 }),
];

fn grasp(criterion: &mut Criterion) {
    let law = PressureLaw::new(4.0).expect("an exponent of at least 1");
    for (name, shape) in SHAPES {
        let contact = || Contact::new(black_box(shape), law).expect("sizes above 0");
        criterion.bench_function(&format!("surface of 201 points, {name}"), |bencher| {
            bencher.iter(|| limit_surface(&contact(), 1.4, 20, 10));
        });
        let contact = contact();
        let load = Load { force: [0.5, 0.3], moment: 0.4 * contact.arm() };
        criterion.bench_function(&format!("margin, {name}"), |bencher| {
            bencher.iter(|| margin(&contact, 1.4, black_box(&load)));
        });
    }
}

criterion_group!(benches, grasp);
criterion_main!(benches);
