//! Answers of ranks beside those of one process.

use super::programs::{Programs, Run};
use crate::Failure;
use mpm_validation::Table;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;

/// Relative out-of-balance force at the end of a load step: what an iteration leaves over is far below what is compared.
const RESIDUAL: &str = "1e-10";

/// Load steps.
const STEPS: u32 = 2;

/// Ranks; more than there are cores share them.
const RANKS: [u32; 4] = [1, 2, 3, 4];

/// Answers of so many ranks.
#[derive(Clone, Debug, Serialize)]
pub struct Answers {
    /// Name of the law.
    pub law: &'static str,
    /// Cells along an edge of the block.
    pub cells: u32,
    /// Ranks.
    pub ranks: u32,
    /// Newton iterations of every load step, of `mpm` and of the ranks.
    pub newton: [Vec<usize>; 2],
    /// Largest difference of positions, displacements and stresses, each of the largest entry of its kind.
    pub apart: f64,
}

/// Runs blocks with these laws on one process and on ranks.
pub(crate) fn of(
    programs: &Programs,
    scene: &Path,
    cells: u32,
    laws: &[(&'static str, &str)],
) -> Result<Vec<Answers>, Failure> {
    let mut answers = Vec::new();
    for &(law, text) in laws {
        let mut set = super::block(cells, STEPS, text);
        set.push(format!("tolerance.residual={RESIDUAL}"));
        set.push("output.fields=[Displacement, CauchyStress]".into());
        let alone = programs.run(0, scene, &set, "alone")?;
        let expected = programs.points("alone")?;
        for ranks in RANKS {
            let run = programs.run(ranks, scene, &set, "ranks")?;
            let apart = apart(&programs.points("ranks")?, &expected)?;
            eprintln!("{law}, {ranks} ranks: {apart:.1e} apart");
            answers.push(Answers { law, cells, ranks, newton: [newton(&alone), newton(&run)], apart });
        }
    }
    Ok(answers)
}

fn newton(run: &Run) -> Vec<usize> {
    run.residuals.iter().map(Vec::len).collect()
}

/// A column's kind: its name without the component behind the last point; positions have a letter alone.
fn kind(name: &str) -> &str {
    match name.rsplit_once('.') {
        Some((kind, _)) => kind,
        None if name.len() == 1 => "position",
        None => name,
    }
}

/// The largest difference, of the largest entry of its kind.
fn apart(found: &BTreeMap<String, Vec<f64>>, expected: &BTreeMap<String, Vec<f64>>) -> Result<f64, Failure> {
    let mut kinds: BTreeMap<&str, [f64; 2]> = BTreeMap::new();
    for (name, expected) in expected {
        let found = found.get(name).filter(|it| it.len() == expected.len());
        let found = found.ok_or_else(|| format!("ranks record another column {name}"))?;
        let [most, apart] = kinds.entry(kind(name)).or_default();
        for (x, y) in found.iter().zip(expected) {
            (*most, *apart) = (most.max(y.abs()), apart.max((x - y).abs()));
        }
    }
    let relative = |[most, apart]: [f64; 2]| if most > 0.0 { apart / most } else { apart };
    Ok(kinds.into_values().map(relative).fold(0.0, f64::max))
}

/// A table of them.
pub(crate) fn table(answers: &[Answers]) -> Table {
    let cells = answers.first().map_or(0, |it| it.cells);
    let text = format!(
        "Answers of ranks beside those of `mpm`: {cells}³ cells, {STEPS} load steps to {RESIDUAL}, more ranks than cores; the largest difference of positions, displacements and stresses, of the largest entry of its kind (at most 1e-9 is wanted)."
    );
    let heads = ["law", "ranks", "Newton iterations of `mpm`", "of the ranks", "apart"];
    let mut table = Table::new(text, &heads);
    for it in answers {
        let list = |of: &[usize]| of.iter().map(usize::to_string).collect::<Vec<_>>().join(" + ");
        let apart = format!("{:.1e}", it.apart);
        table.push([it.law.to_owned(), it.ranks.to_string(), list(&it.newton[0]), list(&it.newton[1]), apart]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_of_the_largest_of_their_kind() {
        let of = |x: f64, xx: f64| {
            BTreeMap::from([
                ("x".to_owned(), vec![1.0, x]),
                ("cauchy_stress.xx".to_owned(), vec![xx]),
                ("cauchy_stress.yy".to_owned(), vec![100.0]),
            ])
        };
        let found = apart(&of(2.0, 1.0), &of(2.0, 0.0)).expect("the same columns");
        assert!((found - 0.01).abs() < 1e-15);
        assert!(apart(&BTreeMap::new(), &of(2.0, 0.0)).is_err());
    }
}
