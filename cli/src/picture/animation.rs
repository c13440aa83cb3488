//! Writes sequences of pictures: as numbered files, or as an animation in one file.

use std::cell::RefCell;
use std::ffi::OsStr;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use anyhow::{Context, Result, bail};
use catamaran::io::{Output, Overwrite};

use super::image::Image;
use crate::common::Force;
use crate::folder::note_older;

/// Frames per second of an animation, by default.
pub const RATE: f64 = 12.0;

/// Pixels of a GIF frame that its colours are learned from, if it has as many; learning takes a
/// tenth of a second.
const LEARNED: usize = 50_000;

/// Formats of animations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Animated PNG: exact.
    Apng,
    /// GIF: 256 colours in each frame.
    Gif,
}

impl Format {
    /// Returns the format that the name of a file selects, if it is one of an animation.
    pub fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_string_lossy().to_ascii_lowercase();
        match &*extension {
            "apng" => Some(Self::Apng),
            "gif" => Some(Self::Gif),
            _ => None,
        }
    }
}

/// Parses a number of frames per second.
pub fn rate(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(rate) if (0.1..=50.0).contains(&rate) => Ok(rate),
        _ => Err("expected frames per second, a number from 0.1 to 50".into()),
    }
}

/// Where frames go.
pub enum Frames {
    /// Each frame goes to a separate file, which is opened when it is written: a process may have
    /// only so many files open.
    Files { paths: std::vec::IntoIter<PathBuf>, overwrite: Overwrite },
    /// All frames go to one file.
    Animation(Animation),
}

impl Frames {
    /// Prepares the files for the frames: an animation if the name of `path` is that of one, else a
    /// file for each frame, `NAME-000`, `NAME-001` and so on, with a note about further such files
    /// that stay. Without a `count` there is one frame, in `path`. A file that exists and may not
    /// be replaced, or that can't be written, is an error already here.
    pub fn create(path: &Path, count: Option<usize>, rate: f64, force: Force) -> Result<Self> {
        if let Some(format) = Format::of(path) {
            let name = path.display();
            let Some(count) = count else { bail!("{name}: an animation needs --frames") };
            let output = force.create(path)?;
            return Ok(Self::Animation(Animation::new(output, format, count, rate)));
        }
        let files = names(path, count);
        files.iter().try_for_each(|path| force.create(path).map(drop))?;
        if count.is_some() {
            note_others(path, &files);
        }
        Ok(Self::Files { paths: files.into_iter(), overwrite: force.overwrite() })
    }

    /// Starts the file of the next frame.
    pub fn file(&mut self) -> Result<Output> {
        match self {
            Self::Files { paths, overwrite } => {
                let path = paths.next().context("more frames than files")?;
                Ok(Output::create(&path, *overwrite)?)
            }
            Self::Animation(_) => bail!("an animation holds only pictures"),
        }
    }

    /// Writes the next frame, a picture.
    pub fn image(&mut self, image: &Image) -> Result<()> {
        match self {
            Self::Files { .. } => image.write(self.file()?),
            Self::Animation(animation) => animation.add(image),
        }
    }

    /// Completes an animation; other files are complete already.
    pub fn finish(self) -> Result<()> {
        match self {
            Self::Files { .. } => Ok(()),
            Self::Animation(animation) => animation.finish(),
        }
    }
}

/// Returns the names of the files of frames.
pub fn names(path: &Path, count: Option<usize>) -> Vec<PathBuf> {
    match count {
        Some(count) if Format::of(path).is_none() => {
            (0..count).map(|i| numbered(path, i)).collect()
        }
        _ => vec![path.to_owned()],
    }
}

/// Returns `folder/name-007.png` for `folder/name.png` and 7.
fn numbered(path: &Path, i: usize) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}-{i:03}.{extension}"))
}

/// Notes frames of earlier runs that stay beside these of `path`.
fn note_others(path: &Path, frames: &[PathBuf]) {
    let text = |part: Option<&OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let (stem, extension) = (text(path.file_stem()), text(path.extension()));
    let written: Vec<String> = frames.iter().map(|frame| text(frame.file_name())).collect();
    let is_end = |end: &str| end.strip_prefix('.') == Some(&*extension);
    let folder = folder.unwrap_or(Path::new("."));
    note_older(folder, "frames", &format!("{stem}-"), is_end, &written);
}

/// A file that is shared with an encoder, and taken back at the end.
struct Shared(Rc<RefCell<Output>>);

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.borrow_mut().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.borrow_mut().flush()
    }
}

/// An animation that is being written; it repeats for ever.
pub struct Animation {
    output: Rc<RefCell<Output>>,
    /// Set by the first frame, which determines the size.
    encoder: Option<Encoder>,
    format: Format,
    frames: u32,
    rate: f64,
    name: String,
}

enum Encoder {
    Apng(Box<png::Writer<Shared>>),
    Gif(gif::Encoder<Shared>),
}

impl Animation {
    /// Returns an animation of `frames` frames.
    fn new(output: Output, format: Format, frames: usize, rate: f64) -> Self {
        let name = output.path().display().to_string();
        let (output, frames) = (Rc::new(RefCell::new(output)), frames as u32);
        Self { output, encoder: None, format, frames, rate, name }
    }

    fn add(&mut self, image: &Image) -> Result<()> {
        let written = self.encode(image);
        written.with_context(|| format!("{}: can't be written", self.name))
    }

    fn encode(&mut self, image: &Image) -> Result<()> {
        let (width, height) = (image.width(), image.height());
        let encoder = match &mut self.encoder {
            Some(encoder) => encoder,
            none => {
                let sink = Shared(Rc::clone(&self.output));
                none.insert(match self.format {
                    Format::Apng => {
                        let mut encoder = png::Encoder::new(sink, width as u32, height as u32);
                        encoder.set_color(png::ColorType::Rgb);
                        encoder.set_depth(png::BitDepth::Eight);
                        encoder.set_animated(self.frames, 0)?;
                        encoder.set_frame_delay((1000.0 / self.rate).round() as u16, 1000)?;
                        Encoder::Apng(Box::new(encoder.write_header()?))
                    }
                    Format::Gif => {
                        let sides = [width, height].map(u16::try_from);
                        let [Ok(width), Ok(height)] = sides else {
                            bail!("{width} x {height} pixels, where GIF has at most 65,535 a side")
                        };
                        let mut encoder = gif::Encoder::new(sink, width, height, &[])?;
                        encoder.set_repeat(gif::Repeat::Infinite)?;
                        Encoder::Gif(encoder)
                    }
                })
            }
        };
        match encoder {
            Encoder::Apng(writer) => writer.write_image_data(image.bytes())?,
            Encoder::Gif(encoder) => {
                // Up to 256 colours are kept; else a net learns them from some of the pixels.
                let speed = (width * height / LEARNED).clamp(1, 30) as i32;
                let [width, height] = [width, height].map(|side| side as u16);
                let mut frame = gif::Frame::from_rgb_speed(width, height, image.bytes(), speed);
                frame.delay = (100.0 / self.rate).round() as u16;
                encoder.write_frame(&frame)?;
            }
        }
        Ok(())
    }

    fn finish(mut self) -> Result<()> {
        let name = self.name;
        match self.encoder.take() {
            Some(Encoder::Apng(writer)) => {
                writer.finish().with_context(|| format!("{name}: can't be written"))?;
            }
            Some(Encoder::Gif(encoder)) => {
                encoder.into_inner().with_context(|| format!("{name}: can't be written"))?;
            }
            None => bail!("{name}: no frame"),
        }
        let output = Rc::into_inner(self.output).context("the animation is still being written")?;
        Ok(output.into_inner().commit()?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_names_of_animations_stay_as_they_are() {
        let name = |path: &str, count| names(Path::new(path), count);
        assert_eq!(name("a/b.png", Some(2)), ["a/b-000.png", "a/b-001.png"].map(PathBuf::from));
        assert_eq!(name("a/b.png", None), ["a/b.png"].map(PathBuf::from));
        for one in ["b.apng", "b.GIF"] {
            assert_eq!(name(one, Some(2)), [one].map(PathBuf::from));
        }
        assert!(rate("0").is_err() && rate("x").is_err() && rate("51").is_err());
        assert_eq!(rate("12.5"), Ok(12.5));
    }
}
