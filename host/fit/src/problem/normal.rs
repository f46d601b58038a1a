//! The normal equations that columns of derivatives make.

use std::ops::Range;

use nalgebra::{DMatrix, DMatrixView};

use super::Columns;
use crate::columns::Products;
use crate::least_squares::Normal;

/// Samples whose products are taken at a time.
const AT_A_TIME: usize = 1024;

impl Normal {
    /// From products of the derivatives by the coordinates `moving`, of so many, and last of the residual.
    pub(super) fn of(dimension: usize, moving: &[usize], products: &Products) -> Self {
        let mut normal = Self::zeros(dimension);
        let residual = moving.len();
        normal.cost = products.of(residual, residual);
        for (a, &i) in moving.iter().enumerate() {
            normal.gradient[i] = products.of(a, residual);
            for (b, &j) in moving.iter().enumerate() {
                normal.curvature[(i, j)] = products.of(a, b);
            }
        }
        normal
    }

    /// Adds so many times the normal equations of some of the coordinates.
    pub fn add_those_of(&mut self, coordinates: &[usize], own: &Self, times: f64) {
        self.cost += times * own.cost;
        for (a, &i) in coordinates.iter().enumerate() {
            self.gradient[i] += times * own.gradient[a];
            for (b, &j) in coordinates.iter().enumerate() {
                self.curvature[(i, j)] += times * own.curvature[(a, b)];
            }
        }
    }

    /// Adds a range of samples: derivatives column by column, and residuals.
    pub fn add(&mut self, columns: &Columns, residual: &[f64], range: Range<usize>) {
        // The residual counts as one more column: one product of few rows at a time, at hand in the cache,
        // gives all.
        let width = columns.len() + 1;
        let mut products = DMatrix::zeros(width, width);
        let mut entries = Vec::with_capacity(AT_A_TIME.min(range.len()) * width);
        for begin in range.clone().step_by(AT_A_TIME) {
            let part = begin..(begin + AT_A_TIME).min(range.end);
            let rows = part.len();
            entries.clear();
            for (_, column) in columns {
                entries.extend_from_slice(&column[part.clone()]);
            }
            entries.extend_from_slice(&residual[part]);
            let down = DMatrixView::from_slice(&entries, rows, width);
            products.gemm(1.0, &down.transpose(), &down, 1.0);
        }
        self.cost += products[(width - 1, width - 1)];
        for (a, (i, _)) in columns.iter().enumerate() {
            self.gradient[*i] += products[(a, width - 1)];
            for (b, (j, _)) in columns.iter().enumerate() {
                self.curvature[(*i, *j)] += products[(a, b)];
            }
        }
    }
}
