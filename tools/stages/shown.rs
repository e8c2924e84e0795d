//! How a picture is shown: the plain image for compositors and the preview, beside its spectral image.
//!
//! Both are made while its rows are rendered. The plain image is the same at any exposure; the preview is made of it, so
//! that another exposure reads no spectra. Where they are missing they are made of the file of the picture.

use std::fs::File;
use std::path::Path;
use std::path::PathBuf;

use niji_exchange::BeyondHalf;
use niji_exchange::Held;
use niji_exchange::ImageWindows;
use niji_exchange::PictureFile;
use niji_exchange::PictureHead;
use niji_exchange::Preview;
use niji_exchange::Provenance;
use niji_exchange::SpectralImage;
use niji_exchange::StripReader;
use niji_exchange::StripWriter;
use niji_geometry::PixelRegion;
use niji_picture::PictureSettings;
use niji_scene::Picture;
use niji_scene::Primaries;

use crate::failure::Failure;
use crate::output;
use crate::output::Temporary;
use crate::progress::Verbosity;
use crate::stages;
use crate::stages::Done;
use crate::stages::Request;
use crate::stages::StageOptions;
use crate::stages::perform;
use crate::stages::render::RenderStage;
use crate::stages::render::companions;
use crate::stages::render::request_with;

/// How a picture is shown: the plain image and the preview beside the spectral image, made anew without it where it is
/// shown otherwise.
pub(super) struct Shown<'a> {
    picture: Picture,
    stage: RenderStage<'a>,
    files: [PathBuf; 2],
}

impl<'a> Shown<'a> {
    pub(super) fn of(stage: &RenderStage<'a>) -> Result<Self, Failure> {
        let settings = stage.settings;
        if settings.shown != settings.picture && stage.target.region != settings.whole()? {
            return Err(Failure::Usage(format!(
                "tiles are shown as their picture was decided on, at picture.exposure_ev = {}, found {}: plan it anew, \
                 or leave --tiles and --region out",
                settings.picture.exposure_ev, settings.shown.exposure_ev
            )));
        }
        Ok(Self {
            picture: settings.shown,
            stage: *stage,
            files: companions(stage.target.path),
        })
    }

    /// What the plain image is asked for with, which is the same at any exposure.
    fn layers(&self) -> Result<Request<'_>, Failure> {
        let decided = self.stage.settings.picture;
        self.of_picture(
            Picture {
                exposure_ev: decided.exposure_ev,
                ..self.picture
            },
            &self.files[0],
        )
    }

    fn preview(&self) -> Result<Request<'_>, Failure> {
        self.of_picture(self.picture, &self.files[1])
    }

    /// The request of the picture if it had been decided on for this.
    fn of_picture<'b>(&'b self, picture: Picture, file: &'b Path) -> Result<Request<'b>, Failure> {
        let settings = PictureSettings {
            picture,
            ..self.stage.settings.clone()
        };
        Ok(Request {
            outputs: vec![file],
            ..request_with(&settings, &self.stage)?
        })
    }

    /// Refuses files of others before anything is rendered.
    pub(super) fn check_free(&self, options: StageOptions) -> Result<(), Failure> {
        let [plain, preview] = &self.files;
        output::check_distinct(&[self.stage.target.path, plain, preview])?;
        stages::check_free_to_make(&self.layers()?, options)?;
        stages::check_free_to_make(&self.preview()?, options)
    }

    /// Both, before the first row of the picture.
    pub(super) fn rows(&self) -> Result<ShownRows, Failure> {
        let [plain, _] = &self.files;
        let pixels = self.stage.target.region;
        let camera = &self.stage.settings.camera;
        let windows = ImageWindows {
            data: pixels,
            display: PixelRegion::frame(camera.width_px, camera.height_px),
        };
        let of_preview = stages::provenance(&self.preview()?)?;
        let of_layers = stages::provenance(&self.layers()?)?;
        let temporary = Temporary::of(plain)?;
        let head = PictureHead::new(self.layers_file(), pixels, of_layers.clone());
        Ok(ShownRows {
            layers: StripWriter::new(head, temporary.handle()?),
            temporary,
            preview: Preview::new(windows, self.picture.exposure_ev, of_preview.clone()),
            provenances: [of_layers, of_preview],
            plain: plain.clone(),
        })
    }

    fn layers_file(&self) -> PictureFile {
        PictureFile::Layers(self.picture.primaries.into())
    }

    /// Makes both, after `done`, of rows as they were rendered, or of what stands in the file.
    pub(super) fn make(
        &self,
        rows: Option<ShownRows>,
        done: Done,
        options: StageOptions,
    ) -> Result<Done, Failure> {
        // Of those that are there the image is told.
        let options = StageOptions {
            verbosity: Verbosity::Quiet,
            ..options
        };
        let [_, preview] = &self.files;
        let mut made = rows.map(ShownRows::finish).transpose()?;
        let made_layers = perform(&self.layers()?, options, |provenance| {
            let made = made.as_mut().filter(|it| it.provenances[0] == provenance);
            match made.and_then(|it| it.layers.take()) {
                Some(layers) => layers.place(),
                None => self.layers_of_file(&provenance),
            }
        })?;
        let mut usual_stops = None;
        let made_preview = perform(&self.preview()?, options, |provenance| {
            let shown = match made.filter(|it| it.provenances[1] == provenance) {
                Some(made) => made.preview,
                None => self.preview_of_file(provenance)?,
            };
            if self.picture.exposure_ev == 0.0 {
                usual_stops = shown.usual_stops();
            }
            output::write_file(preview, |writer| shown.write(writer))
        })?;
        Ok(Done {
            files: [done.files, made_layers.files, made_preview.files].concat(),
            up_to_date: done.up_to_date && made_layers.up_to_date && made_preview.up_to_date,
            seconds: done.seconds + made_layers.seconds + made_preview.seconds,
            usual_stops,
            ..done
        })
    }

    fn layers_of_file(&self, provenance: &Provenance) -> Result<(), Failure> {
        let (path, plain) = (self.stage.target.path, &self.files[0]);
        let damaged = |error| Failure::bad_input(path, error);
        let mut floats = BeyondHalf::default();
        loop {
            let (rows, image) = StripReader::open(path, Held::All).map_err(damaged)?;
            let pixels = image.windows.data;
            let head = PictureHead {
                floats,
                ..PictureHead::new(self.layers_file(), pixels, provenance.clone())
            };
            let failed = |error| output::failed(plain, &error);
            let temporary = Temporary::of(plain)?;
            let mut layers = StripWriter::new(head, temporary.handle()?);
            for rows in rows {
                layers.add(&rows.map_err(damaged)?).map_err(failed)?;
            }
            let beyond = layers.finish().map_err(failed)?;
            if beyond.is_empty() {
                return temporary.place();
            }
            // Half floats do not hold all of them.
            floats = beyond;
        }
    }

    fn preview_of_file(&self, provenance: Provenance) -> Result<Preview, Failure> {
        let [plain, file] = &self.files;
        let exposure_ev = self.picture.exposure_ev;
        if self.picture.primaries == Primaries::Rec709 {
            let preview = Preview::of_plain_image(plain, exposure_ev, provenance);
            return preview.map_err(|error| Failure::bad_input(plain, error));
        }
        let path = self.stage.target.path;
        let damaged = |error| Failure::bad_input(path, error);
        let (rows, image) = StripReader::open(path, Held::Light).map_err(damaged)?;
        let mut preview = Preview::new(image.windows, exposure_ev, provenance);
        for rows in rows {
            let added = preview.add(&rows.map_err(damaged)?);
            added.map_err(|error| output::failed(file, &error))?;
        }
        Ok(preview)
    }
}

/// The plain image and the preview while rows of the picture are rendered.
pub(super) struct ShownRows {
    layers: StripWriter<File>,
    temporary: Temporary,
    preview: Preview,
    /// What they are made for.
    provenances: [Provenance; 2],
    plain: PathBuf,
}

/// Both as they were made.
struct MadeShown {
    /// What they are made for.
    provenances: [Provenance; 2],
    /// None where half floats do not hold its light.
    layers: Option<Temporary>,
    preview: Preview,
}

impl ShownRows {
    pub(super) fn add(&mut self, rows: &SpectralImage) -> Result<(), Failure> {
        let added = self.layers.add(rows).and_then(|()| self.preview.add(rows));
        added.map_err(|error| output::failed(&self.plain, &error))
    }

    fn finish(self) -> Result<MadeShown, Failure> {
        let beyond = self.layers.finish();
        let beyond = beyond.map_err(|error| output::failed(&self.plain, &error))?;
        Ok(MadeShown {
            provenances: self.provenances,
            layers: beyond.is_empty().then_some(self.temporary),
            preview: self.preview,
        })
    }
}
