//! PDF files of one page; text is drawn as the outlines of its letters.

use ab_glyph::{Font, FontRef, OutlineCurve};
use pdf_writer::{Content, Filter, Finish, Name, Pdf, Rect, Ref};
use plotters::prelude::DrawingBackend;
use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingErrorKind, FontTransform,
};
use std::convert::Infallible;

/// Width of the page: 16 centimetres `[1/72 inch]`.
const WIDTH: f32 = 453.5;
/// Height of a letter `m` over that of a line.
const EM: f64 = 1.0 / 1.24;

/// What is drawn on a page.
pub(crate) struct Page {
    size: (u32, u32),
    content: Content,
    /// Opacities that were asked for, by their numbers.
    opacities: Vec<f64>,
}

/// Draws on a page.
pub(crate) struct PdfBackend<'a> {
    page: &'a mut Page,
}

impl Page {
    /// A page for so many pixels.
    pub(crate) fn new(size: (u32, u32)) -> Self {
        let mut content = Content::new();
        // Pixels count downwards from the upper left corner.
        let unit = WIDTH / size.0.max(1) as f32;
        content.transform([unit, 0.0, 0.0, -unit, 0.0, unit * size.1 as f32]);
        Self { size, content, opacities: Vec::new() }
    }

    /// The file.
    pub(crate) fn file(self) -> Vec<u8> {
        let (catalogue, pages, page, content) = (Ref::new(1), Ref::new(2), Ref::new(3), Ref::new(4));
        let mut pdf = Pdf::new();
        pdf.catalog(catalogue).pages(pages);
        pdf.pages(pages).kids([page]).count(1);
        let height = WIDTH * self.size.1 as f32 / self.size.0.max(1) as f32;
        let mut of_page = pdf.page(page);
        of_page.media_box(Rect::new(0.0, 0.0, WIDTH, height)).parent(pages).contents(content);
        let mut resources = of_page.resources();
        let mut states = resources.ext_g_states();
        for (k, opacity) in self.opacities.iter().enumerate() {
            let mut state =
                states.insert(Name(name(k).as_bytes())).start::<pdf_writer::writers::ExtGraphicsState<'_>>();
            state.stroking_alpha(*opacity as f32).non_stroking_alpha(*opacity as f32);
        }
        states.finish();
        resources.finish();
        of_page.finish();
        let stream = miniz_oxide::deflate::compress_to_vec_zlib(&self.content.finish(), 6);
        pdf.stream(content, &stream).filter(Filter::FlateDecode);
        pdf.finish()
    }

    fn colour(&mut self, colour: BackendColor) {
        let part = |x: u8| f32::from(x) / 255.0;
        let (r, g, b) = colour.rgb;
        self.content.set_fill_rgb(part(r), part(g), part(b)).set_stroke_rgb(part(r), part(g), part(b));
        let known = self.opacities.iter().position(|it| *it == colour.alpha);
        let number = known.unwrap_or_else(|| {
            self.opacities.push(colour.alpha);
            self.opacities.len() - 1
        });
        self.content.set_parameters(Name(name(number).as_bytes()));
    }

    fn way(&mut self, path: impl IntoIterator<Item = BackendCoord>) {
        for (k, (x, y)) in path.into_iter().enumerate() {
            match k {
                0 => self.content.move_to(x as f32, y as f32),
                _ => self.content.line_to(x as f32, y as f32),
            };
        }
    }
}

/// Name of an opacity.
fn name(number: usize) -> String {
    format!("A{number}")
}

impl<'a> PdfBackend<'a> {
    pub(crate) fn on(page: &'a mut Page) -> Self {
        Self { page }
    }
}

type Drawn = Result<(), DrawingErrorKind<Infallible>>;

impl DrawingBackend for PdfBackend<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        self.page.size
    }

    fn ensure_prepared(&mut self) -> Drawn {
        Ok(())
    }

    fn present(&mut self) -> Drawn {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, colour: BackendColor) -> Drawn {
        self.page.colour(colour);
        self.page.content.rect(x as f32, y as f32, 1.0, 1.0).fill_nonzero();
        Ok(())
    }

    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S) -> Drawn {
        self.draw_path([from, to], style)
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        (x, y): BackendCoord,
        (to_x, to_y): BackendCoord,
        style: &S,
        fill: bool,
    ) -> Drawn {
        let corners = [(x, y), (to_x, y), (to_x, to_y), (x, to_y)];
        if fill {
            self.fill_polygon(corners, style)
        } else {
            self.draw_path(corners.into_iter().chain([(x, y)]), style)
        }
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Drawn {
        self.page.colour(style.color());
        self.page.content.set_line_width(style.stroke_width() as f32);
        self.page.way(path);
        self.page.content.stroke();
        Ok(())
    }

    fn draw_circle<S: BackendStyle>(
        &mut self,
        (x, y): BackendCoord,
        radius: u32,
        style: &S,
        fill: bool,
    ) -> Drawn {
        // Four arcs as cubic curves, round to 3e-4 of the radius.
        const ARM: f32 = 0.552_284_8;
        let (x, y, r) = (x as f32, y as f32, radius as f32);
        let a = ARM * r;
        self.page.colour(style.color());
        let content = &mut self.page.content;
        content.set_line_width(style.stroke_width() as f32).move_to(x + r, y);
        content.cubic_to(x + r, y + a, x + a, y + r, x, y + r);
        content.cubic_to(x - a, y + r, x - r, y + a, x - r, y);
        content.cubic_to(x - r, y - a, x - a, y - r, x, y - r);
        content.cubic_to(x + a, y - r, x + r, y - a, x + r, y);
        if fill {
            content.fill_nonzero()
        } else {
            content.stroke()
        };
        Ok(())
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        corners: I,
        style: &S,
    ) -> Drawn {
        self.page.colour(style.color());
        self.page.way(corners);
        self.page.content.close_path().fill_nonzero();
        Ok(())
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, (x, y): BackendCoord) -> Drawn {
        let font = FontRef::try_from_slice(dejavu::sans::regular())
            .map_err(|error| DrawingErrorKind::FontError(Box::new(error)))?;
        let em = EM * style.size();
        let unit = em / f64::from(font.units_per_em().unwrap_or(1000.0));
        let glyphs: Vec<_> = text.chars().map(|letter| font.glyph_id(letter)).collect();
        let long: f64 = glyphs.iter().map(|&glyph| unit * f64::from(font.h_advance_unscaled(glyph))).sum();
        let along = match style.anchor().h_pos {
            HPos::Left => 0.0,
            HPos::Center => -0.5 * long,
            HPos::Right => -long,
        };
        let below = em
            * match style.anchor().v_pos {
                VPos::Top => 0.76,
                VPos::Center => 0.27,
                VPos::Bottom => -0.27,
            };
        let (sine, cosine) = match style.transform() {
            FontTransform::None => (0.0, 1.0),
            FontTransform::Rotate90 => (1.0, 0.0),
            FontTransform::Rotate180 => (0.0, -1.0),
            FontTransform::Rotate270 => (-1.0, 0.0),
        };
        self.page.colour(style.color());
        let mut pen = along;
        for glyph in glyphs {
            let place = |at: ab_glyph::Point| {
                let (a, b) = (pen + unit * f64::from(at.x), below - unit * f64::from(at.y));
                let (dx, dy) = (cosine * a - sine * b, sine * a + cosine * b);
                ((f64::from(x) + dx) as f32, (f64::from(y) + dy) as f32)
            };
            let outline = font.outline(glyph);
            outline_of(&mut self.page.content, outline.iter().flat_map(|it| &it.curves), place);
            pen += unit * f64::from(font.h_advance_unscaled(glyph));
        }
        Ok(())
    }
}

/// Fills a letter.
fn outline_of<'a>(
    content: &mut Content,
    curves: impl Iterator<Item = &'a OutlineCurve>,
    place: impl Fn(ab_glyph::Point) -> (f32, f32),
) {
    let mut at = None;
    for curve in curves {
        let from = match curve {
            OutlineCurve::Line(from, _) | OutlineCurve::Quad(from, ..) | OutlineCurve::Cubic(from, ..) => *from,
        };
        if at != Some(from) {
            let (x, y) = place(from);
            content.move_to(x, y);
        }
        at = Some(match *curve {
            OutlineCurve::Line(_, to) => {
                let (x, y) = place(to);
                content.line_to(x, y);
                to
            }
            // A curve of second degree is one of third degree.
            OutlineCurve::Quad(from, by, to) => {
                let third = |end: ab_glyph::Point| {
                    place(ab_glyph::point(
                        end.x + 2.0 / 3.0 * (by.x - end.x),
                        end.y + 2.0 / 3.0 * (by.y - end.y),
                    ))
                };
                let (a, b, c) = (third(from), third(to), place(to));
                content.cubic_to(a.0, a.1, b.0, b.1, c.0, c.1);
                to
            }
            OutlineCurve::Cubic(_, a, b, to) => {
                let (a, b, c) = (place(a), place(b), place(to));
                content.cubic_to(a.0, a.1, b.0, b.1, c.0, c.1);
                to
            }
        });
    }
    if at.is_some() {
        content.close_path().fill_nonzero();
    }
}
