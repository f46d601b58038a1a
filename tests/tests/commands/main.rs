//! What the commands answer: one program, since each takes the linker a second.

mod analyses;
mod change;
mod command_line;
mod compare;
mod grasp;
mod practice;
mod sensor;
mod tables_3;
mod wiring;
