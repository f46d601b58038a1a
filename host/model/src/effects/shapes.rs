//! Shapes that several laws share: the sizes at which strengths are stated, and the time of a warm body.

use super::{Role, Shape};

/// Largest force of the data from which the law was learnt.
pub(super) const FULL_FORCE: Shape = Shape {
    name: "full_force",
    unit: "N",
    meaning: "force at which the strength is stated",
    grid: |scales| vec![scales.force],
    role: Role::Given,
};

/// Largest compression of the data from which the law was learnt.
pub(super) const FULL_COMPRESSION: Shape = Shape {
    name: "full_compression",
    unit: "mm",
    meaning: "compression at which the strength is stated",
    grid: |scales| vec![scales.compression],
    role: Role::Given,
};

/// Largest speed of the data from which the law was learnt.
pub(super) const FULL_SPEED: Shape = Shape {
    name: "full_speed",
    unit: "mm/s",
    meaning: "speed at which the strength is stated",
    grid: |scales| vec![scales.speed],
    role: Role::Given,
};

/// Time in which a body takes on the temperature of the air.
pub(super) const BODY_TIME: Shape = Shape {
    name: "body_time",
    unit: "s",
    meaning: "time in which the body takes on the temperature of the air",
    grid: |scales| [0.03, 0.2].map(|part| part * scales.set_duration).to_vec(),
    role: Role::Fitted(|scales| (0.003 * scales.set_duration, 30.0 * scales.set_duration)),
};
