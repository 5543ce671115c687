//! A symmetric matrix that grows by rows.

use std::ops::Range;

/// The rows up to the diagonal, one after the other; the other half is the same.
#[derive(Clone)]
pub(super) struct Symmetric(Vec<f64>);

impl Symmetric {
    pub(super) fn diagonal(values: &[f64]) -> Self {
        let mut matrix = Self(Vec::new());
        for (row, value) in values.iter().enumerate() {
            matrix.0.extend((0..row).map(|_| 0.0).chain([*value]));
        }
        matrix
    }

    /// The first rows and columns.
    pub(super) fn first(&self, size: usize) -> Self {
        Self(self.0[..begin(size)].to_vec())
    }

    /// Number of rows.
    pub(super) fn size(&self) -> usize {
        // The inverse of `begin`.
        (8 * self.0.len() + 1).isqrt() / 2
    }

    pub(super) fn at(&self, row: usize, column: usize) -> f64 {
        self.0[begin(row.max(column)) + row.min(column)]
    }

    pub(super) fn add(&mut self, row: usize, column: usize, value: f64) {
        self.0[begin(row.max(column)) + row.min(column)] += value;
    }

    /// A row up to the diagonal.
    pub(super) fn row_mut(&mut self, row: usize) -> &mut [f64] {
        &mut self.0[begin(row)..begin(row + 1)]
    }

    /// Adds a state that is equal to another one.
    pub(super) fn push_copy_of(&mut self, other: usize) {
        let row: Vec<f64> = (0..self.size()).map(|at| self.at(other, at)).collect();
        self.0.extend(row);
        self.0.push(self.at(other, other));
    }

    /// Removes rows and columns.
    pub(super) fn remove(&mut self, states: &Range<usize>) {
        let kept: Vec<usize> = (0..self.size()).filter(|at| !states.contains(at)).collect();
        let rows = kept.iter().enumerate();
        self.0 = rows
            .flat_map(|(count, row)| kept[..=count].iter().map(|column| self.at(*row, *column)))
            .collect();
    }
}

/// Place of a row's beginning.
const fn begin(row: usize) -> usize {
    row * (row + 1) / 2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_and_columns_come_and_go() {
        let mut matrix = Symmetric::diagonal(&[1.0, 2.0]);
        matrix.add(0, 1, 5.0);
        matrix.push_copy_of(0);
        matrix.push_copy_of(1);
        let rows = |matrix: &Symmetric| -> Vec<Vec<f64>> {
            let size = matrix.size();
            (0..size)
                .map(|row| (0..size).map(|column| matrix.at(row, column)).collect())
                .collect()
        };
        let whole = [
            [1.0, 5.0, 1.0, 5.0],
            [5.0, 2.0, 5.0, 2.0],
            [1.0, 5.0, 1.0, 5.0],
            [5.0, 2.0, 5.0, 2.0],
        ];
        assert_eq!(rows(&matrix), whole);
        matrix.remove(&(1..3));
        assert_eq!(rows(&matrix), [[1.0, 5.0], [5.0, 2.0]]);
        assert_eq!(rows(&matrix.first(1)), [[1.0]]);
        matrix.row_mut(1)[0] = 7.0;
        assert_eq!(rows(&matrix), [[1.0, 7.0], [7.0, 2.0]]);
    }
}
