//! Animated GIF files.

use crate::{Image, PlotError};
use gif::{Encoder, Frame, Repeat};
use std::borrow::Cow;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// A GIF file that shows pictures of one size one after the other, again and again.
pub struct Animation {
    path: PathBuf,
    size: (u16, u16),
    /// Time per picture `[1/100 s]`.
    delay: u16,
    encoder: Encoder<BufWriter<File>>,
}

impl Animation {
    /// Creates the file for pictures of `size` pixels, `delay` hundredths of a second each.
    ///
    /// # Errors
    /// The file cannot be created, or the size is beyond what GIF can say.
    pub fn create(path: &Path, size: (u32, u32), delay: u16) -> Result<Self, PlotError> {
        let fail = |reason: &dyn ToString| PlotError::write(path, reason.to_string());
        let short = |n: u32| u16::try_from(n).map_err(|_| fail(&format!("{n} pixels are too many for a GIF")));
        let size = (short(size.0)?, short(size.1)?);
        let file = BufWriter::new(File::create(path).map_err(|error| fail(&error))?);
        let mut encoder = Encoder::new(file, size.0, size.1, &[]).map_err(|error| fail(&error))?;
        encoder.set_repeat(Repeat::Infinite).map_err(|error| fail(&error))?;
        Ok(Self { path: path.into(), size, delay, encoder })
    }

    /// Adds a picture.
    ///
    /// # Errors
    /// The file cannot be written, or the picture has another size.
    pub fn add(&mut self, image: &Image) -> Result<(), PlotError> {
        let fail = |reason: &dyn ToString| PlotError::write(&self.path, reason.to_string());
        let (width, height) = self.size;
        if image.size() != (width.into(), height.into()) {
            let reason = format!("a frame has {:?} pixels, expected {width} × {height}", image.size());
            return Err(fail(&reason));
        }
        let (palette, indices) = image.reduced();
        let frame = Frame {
            width,
            height,
            delay: self.delay,
            palette: Some(palette),
            buffer: Cow::Owned(indices),
            ..Frame::default()
        };
        self.encoder.write_frame(&frame).map_err(|error| fail(&error))
    }
}
