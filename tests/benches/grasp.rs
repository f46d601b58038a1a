//! A whole limit surface of 200 points, its tables included, the margin of one load, and three fingers on one
//! object.

use criterion::{Criterion, criterion_group, criterion_main};
use palpate::grasp::balance::{largest_load, least_grip};
use palpate::grasp::{
    Contact, Least, Load, Pose, PressureLaw, Shape, Touch, Wrench, limit_surface, margin,
};
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

/// Three fingers around an object of 4.9 N, of three shapes.
fn hand(criterion: &mut Criterion) {
    let law = PressureLaw::new(4.0).expect("an exponent of at least 1");
    let touch = |k: usize| {
        let angle = std::f64::consts::TAU * k as f64 / 3.0;
        let position = [30.0 * angle.cos(), 30.0 * angle.sin(), 2.0 * k as f64];
        let normal = [-angle.cos(), -angle.sin(), 0.0];
        let pose = Pose::new(position, normal, None).expect("a normal");
        let contact = Contact::new(SHAPES[k].1, law).expect("sizes above 0");
        Touch { pose, contact, friction: 0.7, most: 10.0 }
    };
    let touches = [touch(0), touch(1), touch(2)];
    let load = Wrench { force: [0.2, 0.0, -4.9], moment: [10.0, -20.0, 15.0] };
    criterion.bench_function("least grip of three fingers", |bencher| {
        bencher.iter(|| least_grip(&touches, black_box(&load), 1.5, Least::Sum));
    });
    criterion.bench_function("margin of three fingers", |bencher| {
        bencher.iter(|| largest_load(&touches, black_box(&load)));
    });
}

criterion_group!(benches, grasp, hand);
criterion_main!(benches);
