//! Lines of a lattice, and interpolation from every second one.

/// Directions are coarsened where their lines stand less than this times as far apart as the closest.
const SIMILAR: f64 = 1.5;

/// Lines of a lattice.
#[derive(Clone, Debug)]
pub struct LatticeLines {
    /// Coordinates of the lines of each direction `[L]`; only their ratios matter.
    coordinates: [Vec<f64>; 3],
    /// Number of lines of each direction that closes on itself.
    periods: [Option<u32>; 3],
}

/// A lattice of fewer lines, and where values on the finer lines come from.
#[derive(Clone, Debug)]
pub struct Coarsening {
    /// The coarse lines.
    pub lines: LatticeLines,
    /// Which directions lose every second line.
    pub directions: [bool; 3],
    steps: [Vec<Step>; 3],
}

/// Where the value on a fine line comes from: one coarse line, or two.
#[derive(Clone, Copy, Debug)]
struct Step {
    coarse: [u32; 2],
    weight: [f64; 2],
}

impl LatticeLines {
    /// The lines from `low` to `high`, which then count from 0; all of a direction that closes on itself.
    ///
    /// # Panics
    /// If there are no such lines.
    pub fn of(lines: &[Vec<f64>; 3], periods: [Option<u32>; 3], low: [u32; 3], high: [u32; 3]) -> Self {
        let coordinates = std::array::from_fn(|d| match periods[d] {
            Some(_) => lines[d].clone(),
            None => lines[d][low[d] as usize..=high[d] as usize].to_vec(),
        });
        Self { coordinates, periods }
    }

    /// Numbers of lines.
    pub(crate) fn extent(&self) -> [usize; 3] {
        std::array::from_fn(|d| self.coordinates[d].len())
    }

    /// Numbers of lines of the directions that close on themselves.
    pub(crate) fn periods(&self) -> [Option<u32>; 3] {
        self.periods
    }

    /// The next coarser lattice with the interpolation from it; none where no direction can be coarsened.
    pub fn coarser(&self) -> Option<Coarsening> {
        let directions = self.coarsened();
        if directions == [false; 3] {
            return None;
        }
        let steps = std::array::from_fn(|d| steps(&self.coordinates[d], self.periods[d], directions[d]));
        let mut lines = self.clone();
        for d in (0..3).filter(|&d| directions[d]) {
            lines.coordinates[d] = coarse_lines(&self.coordinates[d], self.periods[d]);
            lines.periods[d] = self.periods[d].map(|n| n / 2);
        }
        Some(Coarsening { lines, directions, steps })
    }

    /// Which directions lose every second line: those whose lines stand closest, if they can.
    fn coarsened(&self) -> [bool; 3] {
        let spacing: [f64; 3] = std::array::from_fn(|d| {
            let lines = &self.coordinates[d];
            let can = match self.periods[d] {
                Some(n) => n % 2 == 0 && n >= 8,
                None => lines.len() > 2,
            };
            if can {
                (lines[lines.len() - 1] - lines[0]).abs() / (lines.len() - 1) as f64
            } else {
                f64::INFINITY
            }
        });
        let least = spacing.iter().copied().fold(f64::INFINITY, f64::min);
        spacing.map(|spacing| spacing.is_finite() && spacing <= SIMILAR * least)
    }
}

impl Coarsening {
    /// Calls `see` with the coarse nodes that a fine node's value comes from, and their weights.
    ///
    /// # Panics
    /// If the node stands on none of the fine lines.
    pub fn for_each_parent(&self, fine: [u32; 3], mut see: impl FnMut([u32; 3], f64)) {
        let [x, y, z] = std::array::from_fn(|d| self.steps[d][fine[d] as usize]);
        for (&kz, &wz) in z.coarse.iter().zip(&z.weight).filter(|it| *it.1 != 0.0) {
            for (&ky, &wy) in y.coarse.iter().zip(&y.weight).filter(|it| *it.1 != 0.0) {
                for (&kx, &wx) in x.coarse.iter().zip(&x.weight).filter(|it| *it.1 != 0.0) {
                    see([kx, ky, kz], wx * wy * wz);
                }
            }
        }
    }
}

fn steps(lines: &[f64], periodic: Option<u32>, coarsened: bool) -> Vec<Step> {
    let n = periodic.map_or(lines.len(), |n| n as usize);
    (0..n)
        .map(|i| {
            let (low, high) = (i as u32 / 2, i as u32 / 2 + 1);
            if !coarsened {
                return Step { coarse: [i as u32; 2], weight: [1.0, 0.0] };
            }
            if i % 2 == 0 {
                return Step { coarse: [low; 2], weight: [1.0, 0.0] };
            }
            match periodic {
                // Lines that close on themselves are equally spaced.
                Some(n) => Step { coarse: [low, high % (n / 2)], weight: [0.5; 2] },
                None if i + 1 == n => Step { coarse: [low, high], weight: [0.5; 2] },
                None => {
                    let upper = (lines[i] - lines[i - 1]) / (lines[i + 1] - lines[i - 1]);
                    Step { coarse: [low, high], weight: [1.0 - upper, upper] }
                }
            }
        })
        .collect()
}

/// Every second line, and one beyond the last where that is not one of them.
fn coarse_lines(lines: &[f64], periodic: Option<u32>) -> Vec<f64> {
    let mut coarse: Vec<f64> = lines.iter().copied().step_by(2).collect();
    match periodic {
        Some(n) => coarse.truncate(n as usize / 2),
        None if lines.len().is_multiple_of(2) => {
            let n = lines.len();
            coarse.push(lines[n - 1] + (lines[n - 1] - lines[n - 2]));
        }
        None => {}
    }
    coarse
}
