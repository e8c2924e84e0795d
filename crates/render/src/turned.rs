//! Tables turned so that columns become rows, four of each at a time.

use glam::Mat4;
use glam::Vec4;

/// Write the columns of a table of rows of `n_columns` values each to its own place, the first column to
/// the first place and so on.
pub(crate) fn turn<'a>(
    table: &[f32],
    n_columns: usize,
    mut columns: impl Iterator<Item = &'a mut [f32]>,
) {
    for first in (0..n_columns).step_by(4) {
        let four = [(); 4].map(|()| columns.next());
        match four {
            [Some(a), Some(b), Some(c), Some(d)] => {
                turn_four(table, n_columns, first, [a, b, c, d]);
            }
            fewer => {
                for (column, to) in (first..).zip(fewer.into_iter().flatten()) {
                    let values = table.iter().skip(column).step_by(n_columns);
                    for (to, from) in to.iter_mut().zip(values) {
                        *to = *from;
                    }
                }
            }
        }
    }
}

/// Four columns, four rows at a time.
fn turn_four(table: &[f32], n_columns: usize, first: usize, mut columns: [&mut [f32]; 4]) {
    let n_rows = columns[0].len();
    let n_whole = n_rows / 4 * 4;
    for row in (0..n_whole).step_by(4) {
        let part = |step: usize| Vec4::from_slice(&table[(row + step) * n_columns + first..]);
        let turned = Mat4::from_cols(part(0), part(1), part(2), part(3)).transpose();
        let parts = [turned.x_axis, turned.y_axis, turned.z_axis, turned.w_axis];
        for (column, part) in columns.iter_mut().zip(parts) {
            part.write_to_slice(&mut column[row..]);
        }
    }
    for row in n_whole..n_rows {
        let part = &table[row * n_columns + first..];
        for (column, value) in columns.iter_mut().zip(part) {
            column[row] = *value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_of_any_table_become_rows() {
        for n_columns in 1..10 {
            for n_rows in 1..10 {
                let table: Vec<f32> = (0..n_rows * n_columns).map(|at| at as f32).collect();
                let mut turned = vec![f32::NAN; table.len()];
                turn(&table, n_columns, turned.chunks_mut(n_rows));
                for (at, value) in turned.iter().enumerate() {
                    let (column, row) = (at / n_rows, at % n_rows);
                    // Whole numbers: exact.
                    assert_eq!(*value, (row * n_columns + column) as f32);
                }
            }
        }
    }
}
