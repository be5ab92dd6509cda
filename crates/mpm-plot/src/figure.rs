//! Panels side by side, as text or as pixels.

use crate::labels::FONT;
use crate::pdf::{Page, PdfBackend};
use crate::{Curves, PlotError, Shapes, palette};
use plotters::coord::Shift;
use plotters::prelude::{
    BitMapBackend, DrawingArea, DrawingBackend, FontStyle, IntoDrawingArea, SVGBackend, WHITE,
};
use plotters::style::register_font;
use std::path::Path;

/// Most panels in a row, if nothing else is said.
const ACROSS: usize = 6;
/// Height of letters, if nothing else is said `[pixels]`.
const TEXT: u32 = 13;
/// Part of the width of a picture that letters of 7 points have on 16 centimetres.
const LEGIBLE: f64 = 0.0154;

/// One panel of a figure.
#[derive(Clone, Debug)]
pub enum Panel {
    /// Curves over two axes.
    Curves(Curves),
    /// A body of domains, to scale; what reaches beyond the range is cut off.
    Shapes(Shapes),
}

/// Panels side by side.
#[derive(Clone, Copy, Debug)]
pub struct Figure<'a> {
    /// The panels, row by row.
    pub panels: &'a [Panel],
    /// Panels in a row.
    pub columns: usize,
    /// Width and height of a panel `[pixels]`.
    pub panel: (u32, u32),
    /// Height of letters `[pixels]`.
    pub text: u32,
}

/// A drawn figure: red, green and blue of every pixel.
#[derive(Clone, Debug)]
pub struct Image {
    width: u32,
    pixels: Vec<u8>,
}

impl<'a> Figure<'a> {
    /// Panels of 460 × 380 pixels, at most six in a row.
    pub fn new(panels: &'a [Panel]) -> Self {
        Self { panels, columns: panels.len().clamp(1, ACROSS), panel: (460, 380), text: TEXT }
    }

    /// With letters that can be read where the picture is 16 centimetres wide.
    pub fn legible(mut self) -> Self {
        self.text = TEXT.max((LEGIBLE * f64::from(self.size().0)).ceil() as u32);
        self
    }

    /// Width and height `[pixels]`.
    pub fn size(&self) -> (u32, u32) {
        (self.panel.0 * self.columns as u32, self.panel.1 * self.rows() as u32)
    }

    fn rows(&self) -> usize {
        self.panels.len().div_ceil(self.columns.max(1)).max(1)
    }

    /// The figure as the text of an SVG file.
    ///
    /// # Errors
    /// It cannot be drawn.
    pub fn svg(&self) -> Result<String, PlotError> {
        let mut text = String::new();
        self.draw(SVGBackend::with_string(&mut text, self.size()).into_drawing_area())?;
        Ok(text)
    }

    /// The figure in pixels.
    ///
    /// # Errors
    /// It cannot be drawn.
    pub fn image(&self) -> Result<Image, PlotError> {
        let (width, height) = self.size();
        let mut pixels = vec![0; 3 * (width * height) as usize];
        self.draw(BitMapBackend::with_buffer(&mut pixels, (width, height)).into_drawing_area())?;
        Ok(Image { width, pixels })
    }

    /// The figure as the bytes of a PDF file of one page.
    ///
    /// # Errors
    /// It cannot be drawn.
    pub fn pdf(&self) -> Result<Vec<u8>, PlotError> {
        let mut page = Page::new(self.size());
        self.draw(PdfBackend::on(&mut page).into_drawing_area())?;
        Ok(page.file())
    }

    /// Draws the figure into a file; its ending, `.svg`, `.png` or `.pdf`, says the format.
    ///
    /// # Errors
    /// It cannot be drawn, the file cannot be written, or has another ending.
    pub fn save(&self, path: &Path) -> Result<(), PlotError> {
        match path.extension().and_then(|ending| ending.to_str()) {
            Some("svg") => std::fs::write(path, self.svg()?).map_err(|error| PlotError::write(path, error)),
            Some("pdf") => std::fs::write(path, self.pdf()?).map_err(|error| PlotError::write(path, error)),
            Some("png") => self.image()?.save(path),
            _ => Err(PlotError::Format { path: path.into() }),
        }
    }

    fn draw<DB>(&self, area: DrawingArea<DB, Shift>) -> Result<(), PlotError>
    where
        DB: DrawingBackend,
        DB::ErrorType: 'static,
    {
        // The one font there is; registering it again changes nothing.
        register_font(FONT, FontStyle::Normal, dejavu::sans::regular())
            .map_err(|_| PlotError::draw("the font is broken"))?;
        area.fill(&WHITE).map_err(PlotError::draw)?;
        for (panel, part) in self.panels.iter().zip(area.split_evenly((self.rows(), self.columns))) {
            match panel {
                Panel::Curves(curves) => curves.draw(&part, self.text)?,
                Panel::Shapes(shapes) => shapes.draw(&part, self.text)?,
            }
        }
        area.present().map_err(PlotError::draw)
    }
}

impl Image {
    /// Width and height `[pixels]`.
    pub fn size(&self) -> (u32, u32) {
        (self.width, (self.pixels.len() / 3) as u32 / self.width.max(1))
    }

    /// Writes a PNG file of all colours.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), PlotError> {
        let file = std::fs::File::create(path).map_err(|error| PlotError::write(path, error))?;
        let (width, height) = self.size();
        let mut encoder = png::Encoder::new(std::io::BufWriter::new(file), width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::Fast);
        encoder.set_filter(png::FilterType::Sub);
        let written = encoder.write_header().and_then(|mut writer| {
            writer.write_image_data(&self.pixels)?;
            writer.finish()
        });
        written.map_err(|error| PlotError::write(path, error))
    }

    /// Writes a PNG file of at most 256 colours: small, to be kept.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn save_small(&self, path: &Path) -> Result<(), PlotError> {
        std::fs::write(path, self.small_png()?).map_err(|error| PlotError::write(path, error))
    }

    /// The bytes of a PNG file of at most 256 colours.
    ///
    /// # Errors
    /// It cannot be encoded.
    pub fn small_png(&self) -> Result<Vec<u8>, PlotError> {
        let mut bytes = Vec::new();
        self.small(&mut bytes).map_err(PlotError::draw)?;
        Ok(bytes)
    }

    fn small(&self, out: impl std::io::Write) -> Result<(), png::EncodingError> {
        let (width, height) = self.size();
        let (colours, indices) = self.reduced();
        let mut encoder = png::Encoder::new(out, width, height);
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::Best);
        // PNG filters predict shades; they do not help with the numbers of palette colours.
        encoder.set_filter(png::FilterType::NoFilter);
        encoder.set_palette(colours);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&indices)?;
        writer.finish()
    }

    /// The colours, three numbers each, 256 at most, and for each pixel the number of its colour.
    pub(crate) fn reduced(&self) -> (Vec<u8>, Vec<u8>) {
        palette::reduced(&self.pixels)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Animation, ColourBar, Patch};

    fn panels(value: f64) -> Vec<Panel> {
        vec![Panel::Shapes(Shapes {
            title: "a triangle".into(),
            range: [(0.0, 1.0), (0.0, 1.0)],
            patches: vec![Patch::new(vec![(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)], value)],
            discs: vec![((0.7, 0.7), 0.0)],
            radius: 0.1,
            bar: Some(ColourBar { label: "rho".into(), range: (0.0, 2.0) }),
            ..Shapes::default()
        })]
    }

    #[test]
    fn all_formats_are_written_and_no_other() {
        let directory = tempfile::tempdir().unwrap();
        let panels = panels(1.0);
        for file in ["a.svg", "a.png", "a.pdf"] {
            Figure::new(&panels).save(&directory.path().join(file)).unwrap();
            assert!(std::fs::metadata(directory.path().join(file)).unwrap().len() > 500);
        }
        let svg = std::fs::read_to_string(directory.path().join("a.svg")).unwrap();
        // The triangle in the colour of 1, and the ticks of the bar.
        assert!(svg.contains("<polygon") && svg.contains("a triangle") && svg.contains("#FDE725"), "{svg}");
        assert!(svg.contains("\n0.5\n") && svg.contains("\n1.5\n"), "{svg}");
        let error = Figure::new(&panels).save(&directory.path().join("a.bmp")).unwrap_err();
        assert!(error.to_string().contains("ends in .svg, .png or .pdf"), "{error}");
    }

    #[test]
    fn frames_become_an_animation() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a.gif");
        let mut animation = Animation::create(&path, (460, 380), 10).unwrap();
        for value in [0.0, 0.5, 1.0] {
            animation.add(&Figure::new(&panels(value)).image().unwrap()).unwrap();
        }
        let other = Figure { panel: (10, 80), ..Figure::new(&panels(0.0)) }.image().unwrap();
        assert!(animation.add(&other).unwrap_err().to_string().contains("expected 460 × 380"));
        drop(animation);
        let mut decoder = gif::DecodeOptions::new().read_info(std::fs::File::open(&path).unwrap()).unwrap();
        assert_eq!((decoder.width(), decoder.height()), (460, 380));
        let mut frames = 0;
        while decoder.read_next_frame().unwrap().is_some() {
            frames += 1;
        }
        assert_eq!(frames, 3);
    }
}
