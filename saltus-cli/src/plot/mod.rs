//! Drawings as SVG and PNG, with the font they need built in.

mod axes;
mod contour;
pub(crate) mod ground;
pub(crate) mod line;
pub(crate) mod map;
pub(crate) mod palette;
pub(crate) mod sheet;

use std::path::{Path, PathBuf};

use plotters::prelude::{BitMapBackend, DrawingBackend, IntoDrawingArea, SVGBackend};

use crate::error::CliError;
use axes::Pen;
pub(crate) use axes::{padded, span, tick};
use sheet::Sheet;

/// A file to draw to.
#[derive(Clone, Debug)]
pub(crate) struct PlotFile {
    path: PathBuf,
    kind: Kind,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    Svg,
    Png,
}

/// Pixels of a PNG for each unit of a drawing's size.
const PNG_SCALE: u32 = 2;

/// Result of drawing on a backend.
pub(crate) type Drawn<DB> =
    Result<(), plotters::drawing::DrawingAreaErrorKind<<DB as DrawingBackend>::ErrorType>>;

impl PlotFile {
    /// Parser of the flag: the ending says what kind of file it is.
    pub(crate) fn parse(text: &str) -> Result<PlotFile, String> {
        let path = PathBuf::from(text);
        let ending = path
            .extension()
            .map(|ending| ending.to_string_lossy().to_ascii_lowercase());
        match ending.as_deref() {
            Some("svg") => Ok(PlotFile {
                path,
                kind: Kind::Svg,
            }),
            Some("png") => Ok(PlotFile {
                path,
                kind: Kind::Png,
            }),
            _ => Err("the name must end in .svg or .png".into()),
        }
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// The bytes of the file.
    pub(crate) fn draw(&self, sheet: &Sheet) -> Result<Vec<u8>, CliError> {
        let failed = |reason: String| CliError::Plot {
            file: self.path.clone(),
            reason,
        };
        axes::register_font().map_err(failed)?;
        match self.kind {
            Kind::Svg => svg(sheet).map_err(failed),
            Kind::Png => png(sheet).map_err(failed),
        }
    }
}

fn svg(sheet: &Sheet) -> Result<Vec<u8>, String> {
    let mut text = String::new();
    let area = SVGBackend::with_string(&mut text, sheet.size()).into_drawing_area();
    sheet
        .draw(&area, Pen::new(1))
        .map_err(|error| error.to_string())?;
    drop(area);
    Ok(text.into_bytes())
}

fn png(sheet: &Sheet) -> Result<Vec<u8>, String> {
    let (width, height) = sheet.size();
    let size = (width * PNG_SCALE, height * PNG_SCALE);
    let mut pixels = vec![0; 3 * size.0 as usize * size.1 as usize];
    let area = BitMapBackend::with_buffer(&mut pixels, size).into_drawing_area();
    sheet
        .draw(&area, Pen::new(PNG_SCALE))
        .map_err(|error| error.to_string())?;
    drop(area);
    encode(&pixels, size).map_err(|error| error.to_string())
}

fn encode(pixels: &[u8], (width, height): (u32, u32)) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(pixels)?;
    writer.finish()?;
    Ok(bytes)
}
