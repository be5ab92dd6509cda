//! What a point remembers besides its elastic state.

/// A quantity that results can show.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct FieldInfo {
    /// Its name, in words joined by underscores.
    pub name: &'static str,
    /// Numbers per point: 1 for a scalar.
    pub components: usize,
    /// Its unit in terms of force F, length L and time T: `F/L²`, or `-` for a pure number.
    pub unit: &'static str,
}

/// What a law remembers of a point: `NUMBERS` numbers in checkpoints, [`FieldInfo`]s in results.
pub trait History: Copy + Send + Sync + Sized {
    /// Numbers per point in a checkpoint.
    const NUMBERS: usize;

    /// What is shown of it, in the order of [`History::show`]; a law that wraps another shows that one's besides.
    const FIELDS: &'static [FieldInfo];

    /// Appends exactly `NUMBERS` numbers, from which a run goes on.
    fn store(&self, to: &mut Vec<f64>);

    /// The history that `NUMBERS` finite numbers are, bit for bit.
    ///
    /// # Errors
    /// What no history of this kind can be.
    fn restore(from: &[f64]) -> Result<Self, String>;

    /// Appends the components of all `FIELDS`; unless a law says otherwise they are the stored numbers.
    fn show(&self, to: &mut Vec<f64>) {
        self.store(to);
    }
}

impl History for () {
    const NUMBERS: usize = 0;
    const FIELDS: &'static [FieldInfo] = &[];

    fn store(&self, _to: &mut Vec<f64>) {}

    fn restore(_from: &[f64]) -> Result<Self, String> {
        Ok(())
    }
}
