//! Fields over points at rest: stiffnesses and strengths that differ from point to point.

use crate::files::{NamedColumns, SceneFiles};
use crate::language::{LayerInput, PointField};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Evaluates fields; what a field takes long to prepare is kept.
pub(super) struct Fields<'a> {
    files: &'a dyn SceneFiles,
    tables: RefCell<BTreeMap<String, NamedColumns>>,
    waves: RefCell<BTreeMap<u64, Vec<Wave>>>,
}

/// One of the waves whose sum is a random field of unit variance.
struct Wave {
    /// Wave vector at a correlation length of one `[-]`.
    vector: [f64; 3],
    /// `[rad]`
    phase: f64,
}

/// Waves of a random field: the sum is normally distributed but for one part in so many.
const WAVES: usize = 1000;

impl<'a> Fields<'a> {
    pub fn new(files: &'a dyn SceneFiles) -> Self {
        Self { files, tables: RefCell::default(), waves: RefCell::default() }
    }

    /// Value of a field at `x` `[L]`, whose last coordinate is the height.
    ///
    /// # Errors
    /// A sentence: the field has no value there.
    pub fn at(&self, field: &PointField, x: &[f64]) -> Result<f64, String> {
        let height = x[x.len() - 1];
        match field {
            PointField::Linear { at, value, gradient } => Ok(value.0 + gradient.0 * (at.0 - height)),
            PointField::Layers(layers) => layer_at(layers, height),
            PointField::Table { file, column } => {
                self.with_table(file, |table| table.value(column, x)).and_then(|value| value)
            }
            PointField::Random { mean, variation, correlation_length, vertical_correlation_length, seed } => {
                let mut lengths = [correlation_length.0; 3];
                lengths[x.len() - 1] = vertical_correlation_length.map_or(correlation_length.0, |it| it.0);
                let logarithmic = (variation.0 * variation.0).ln_1p();
                let normal = self.normal(*seed, x, &lengths);
                Ok(mean.0 * (logarithmic.sqrt() * normal - 0.5 * logarithmic).exp())
            }
        }
    }

    /// What `use_of` makes of a table, which is read once.
    pub fn with_table<T>(&self, file: &str, use_of: impl FnOnce(&NamedColumns) -> T) -> Result<T, String> {
        let mut tables = self.tables.borrow_mut();
        if !tables.contains_key(file) {
            tables.insert(file.into(), self.files.columns(file)?);
        }
        Ok(use_of(&tables[file]))
    }

    /// A random field of mean 0, variance 1 and the correlation exp(−r²/l²): the spectral method (Shinozuka & Deodatis
    /// 1991) with wave vectors drawn from the spectrum, which is normal with the variance 2/l² in each direction.
    fn normal(&self, seed: u64, x: &[f64], lengths: &[f64; 3]) -> f64 {
        let mut waves = self.waves.borrow_mut();
        let waves = waves.entry(seed).or_insert_with(|| {
            let mut random = Random(seed);
            let wave = |_| Wave { vector: [(); 3].map(|()| random.normal()), phase: TAU * random.uniform() };
            (0..WAVES).map(wave).collect()
        });
        let root = 2.0_f64.sqrt();
        let wave = |wave: &Wave| {
            let along: f64 = x.iter().zip(lengths).zip(&wave.vector).map(|((x, l), k)| root * k * x / l).sum();
            (along + wave.phase).cos()
        };
        waves.iter().map(wave).sum::<f64>() * (2.0 / WAVES as f64).sqrt()
    }
}

fn layer_at(layers: &[LayerInput], height: f64) -> Result<f64, String> {
    let layer = layers.iter().rev().find(|layer| height <= layer.top.0);
    match (layer, layers.first()) {
        (Some(layer), _) => Ok(layer.value.0 + layer.gradient.0 * (layer.top.0 - height)),
        (None, Some(first)) => Err(format!("it lies above the first layer, whose top is at {}", first.top.0)),
        (None, None) => Err("expected at least one layer".into()),
    }
}

/// Refuses layers that do not go down.
pub(super) fn check_layers(layers: &[LayerInput]) -> Result<(), String> {
    if layers.is_empty() {
        return Err("expected at least one layer".into());
    }
    match layers.windows(2).find(|pair| pair[1].top.0 >= pair[0].top.0) {
        None => Ok(()),
        Some(pair) => Err(format!(
            "a layer with its top at {} stands below one at {}: expected tops from the highest down",
            pair[1].top.0, pair[0].top.0
        )),
    }
}

/// `∫ field dh` from `height` up to `top` of a number, `Linear` or `Layers`.
pub(super) fn integral(field: &PointField, height: f64, top: f64) -> Result<f64, String> {
    match field {
        PointField::Linear { at, value, gradient } => {
            let middle = 0.5 * (height + top);
            Ok((value.0 + gradient.0 * (at.0 - middle)) * (top - height))
        }
        PointField::Layers(layers) => {
            layer_at(layers, top)?;
            let mut sum = 0.0;
            for (k, layer) in layers.iter().enumerate() {
                let upper = layer.top.0.min(top);
                let lower = layers.get(k + 1).map_or(height, |next| next.top.0.max(height));
                if upper > lower {
                    let middle = 0.5 * (upper + lower);
                    sum += (layer.value.0 + layer.gradient.0 * (layer.top.0 - middle)) * (upper - lower);
                }
            }
            Ok(sum)
        }
        PointField::Table { .. } | PointField::Random { .. } => {
            Err("expected a number, `Linear` or `Layers`, whose integral over the depth is known".into())
        }
    }
}

impl NamedColumns {
    /// The value of `column` at `x`.
    fn value(&self, column: &str, x: &[f64]) -> Result<f64, String> {
        let values = self.column(column)?;
        let names = &["x", "y", "z"][..x.len()];
        let vertical = names[x.len() - 1];
        if self.has(names[0]) {
            return Ok(values[self.nearest(x)?]);
        }
        let heights = self.column(vertical)?;
        let (at, mut below, mut above) = (x[x.len() - 1], None, None);
        for k in 0..heights.len() {
            if heights[k] <= at && below.is_none_or(|other: usize| heights[other] < heights[k]) {
                below = Some(k);
            }
            if heights[k] >= at && above.is_none_or(|other: usize| heights[other] > heights[k]) {
                above = Some(k);
            }
        }
        match (below, above) {
            (Some(low), Some(high)) if heights[low] < heights[high] => {
                let part = (at - heights[low]) / (heights[high] - heights[low]);
                Ok(values[low] + part * (values[high] - values[low]))
            }
            (Some(only), Some(_)) => Ok(values[only]),
            _ => Err(format!("{}: no rows on both sides of {vertical} = {at}", self.file)),
        }
    }

    /// The row nearest to `x`, the first of several.
    pub(super) fn nearest(&self, x: &[f64]) -> Result<usize, String> {
        let mut columns = Vec::with_capacity(x.len());
        for name in &["x", "y", "z"][..x.len()] {
            columns.push(self.column(name)?);
        }
        let distance = |row: usize| -> f64 { columns.iter().zip(x).map(|(c, x)| (c[row] - x).powi(2)).sum() };
        let nearest = (0..self.rows()).min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
        nearest.ok_or_else(|| format!("{} has no rows", self.file))
    }
}

/// Numbers that look random: splitmix64 (Steele, Lea & Flood 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Above 0, at most 1.
    fn uniform(&mut self) -> f64 {
        ((self.next() >> 11) + 1) as f64 / (1_u64 << 53) as f64
    }

    /// Box & Muller 1958.
    fn normal(&mut self) -> f64 {
        let radius = (-2.0 * self.uniform().ln()).sqrt();
        radius * (TAU * self.uniform()).cos()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::NoFiles;
    use crate::language::{Finite, Positive};

    fn layer(top: f64, value: f64, gradient: f64) -> LayerInput {
        LayerInput { top: Finite(top), value: Finite(value), gradient: Finite(gradient) }
    }

    #[test]
    fn depth_is_measured_downwards() {
        let fields = Fields::new(&NoFiles);
        let linear = PointField::Linear { at: Finite(10.0), value: Finite(5.0), gradient: Finite(1.5) };
        assert_eq!(fields.at(&linear, &[3.0, 8.0]), Ok(8.0));
        assert_eq!(fields.at(&linear, &[3.0, 8.0, 6.0]), Ok(11.0));
        let layers = PointField::Layers(vec![layer(10.0, 5.0, 0.0), layer(4.0, 20.0, 2.0)]);
        let at = |height: f64| fields.at(&layers, &[0.0, height]);
        assert_eq!((at(10.0), at(4.5), at(4.0), at(1.0)), (Ok(5.0), Ok(5.0), Ok(20.0), Ok(26.0)));
        assert!(at(10.5).unwrap_err().contains("above the first layer"));
        // ∫ from 1 to 9: 5 · 5 in the upper layer, (20 + 26)/2 · 3 in the lower.
        assert_eq!(integral(&layers, 1.0, 9.0), Ok(94.0));
        assert_eq!(integral(&linear, 2.0, 6.0), Ok(4.0 * (5.0 + 1.5 * 6.0)));
        assert!(check_layers(&[layer(1.0, 1.0, 0.0), layer(2.0, 1.0, 0.0)]).is_err());
    }

    #[test]
    fn tables_take_the_nearest_row_or_the_line_between() {
        let column = |name: &str, values: &[f64]| (name.to_string(), values.to_vec());
        let depths = NamedColumns {
            file: "s.csv".into(),
            columns: vec![column("y", &[4.0, 0.0, 2.0]), column("s", &[10.0, 30.0, 14.0])],
        };
        let at = |height: f64| depths.value("s", &[7.0, height]);
        assert_eq!((at(4.0), at(3.0), at(0.5)), (Ok(10.0), Ok(12.0), Ok(26.0)));
        assert!(at(4.5).unwrap_err().contains("no rows on both sides of y = 4.5"));
        let places = NamedColumns {
            file: "s.csv".into(),
            columns: vec![column("x", &[0.0, 1.0]), column("y", &[0.0, 0.0]), column("s", &[1.0, 2.0])],
        };
        assert_eq!(places.value("s", &[0.6, 5.0]), Ok(2.0));
        assert!(places.value("t", &[0.6, 5.0]).unwrap_err().contains("no column `t`"));
    }

    #[test]
    fn random_fields_have_their_mean_variation_and_correlation() {
        let (mean, variation) = (20.0, 0.3);
        let random = |seed| PointField::Random {
            mean: Positive(mean),
            variation: Positive(variation),
            correlation_length: Positive(2.0),
            vertical_correlation_length: Some(Positive(0.5)),
            seed,
        };
        let logarithmic = f64::ln_1p(variation * variation);
        let n = 400;
        // Over many seeds: moments of the logarithm at one place, and its products with other places.
        let (mut sum, mut squares, mut sideways, mut downwards) = (0.0, 0.0, 0.0, 0.0);
        for seed in 0..n {
            let fields = Fields::new(&NoFiles);
            let normal = |x: f64, y: f64| {
                let value = fields.at(&random(seed), &[x, y]).unwrap();
                ((value / mean).ln() + 0.5 * logarithmic) / logarithmic.sqrt()
            };
            let here = normal(3.0, 1.0);
            sum += here;
            squares += here * here;
            sideways += here * normal(4.0, 1.0);
            downwards += here * normal(3.0, 1.5);
        }
        let per = 1.0 / n as f64;
        assert!(
            (sum * per).abs() < 0.15 && (squares * per - 1.0).abs() < 0.2,
            "{} {}",
            sum * per,
            squares * per
        );
        assert!((sideways * per - f64::exp(-0.25)).abs() < 0.2, "{}", sideways * per);
        assert!((downwards * per - f64::exp(-1.0)).abs() < 0.2, "{}", downwards * per);
        let fields = Fields::new(&NoFiles);
        let again = Fields::new(&NoFiles);
        assert_eq!(fields.at(&random(7), &[1.0, 2.0]), again.at(&random(7), &[1.0, 2.0]));
        assert_ne!(fields.at(&random(7), &[1.0, 2.0]), again.at(&random(8), &[1.0, 2.0]));
    }
}
