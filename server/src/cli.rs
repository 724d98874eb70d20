//! The command line.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand, ValueEnum};
use fogbank_core::airlight::ComparedAirlight;
use fogbank_core::image::Format;
use fogbank_core::request::{Layer, Quality, Tonemap};
use fogbank_core::scene::{Airlight, Vec3};
use schemars::{JsonSchema, schema_for};
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::fs::OpenOptions;
use std::io;
use std::path::{Path, PathBuf};

/// Previews of fog by published closed forms: a server with a page, and a command line.
///
/// Without a command it serves. Every option can also be given as an environment variable.
#[derive(Parser)]
#[command(name = "fogbank", version, args_conflicts_with_subcommands = true)]
#[command(after_help = "Exit codes: 0 done, 1 failed, 2 wrong usage, 3 the scene or a value is \
    invalid, 4 there is no such device, 5 the deadline passed.")]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Option<Command>,
    /// Options of `serve`, which need not be named.
    #[command(flatten)]
    pub serve: ServeArgs,
}

/// What to do.
#[derive(Subcommand)]
pub enum Command {
    /// Serves the API and the page.
    Serve(ServeArgs),
    /// Renders a scene into a file.
    Render(RenderArgs),
    /// Prints the numbers along one ray as JSON.
    Probe(ProbeArgs),
    /// Prints how far one airlight estimator is from another as JSON.
    Compare(CompareArgs),
    /// Prints what pictures can be made on, how fast, and by how much the backends differ.
    Backends,
    /// Prints the JSON schema of a scene.
    Schema,
    /// Prints a file of another program as a scene: .csv of time, x, y, z, radius, extinction.
    Import(ImportArgs),
    /// Prints a grey image as a fogmap, or writes a fogmap as an image.
    Fogmap(FogmapArgs),
}

/// Options of `import`.
#[derive(Args)]
pub struct ImportArgs {
    /// The file.
    pub file: PathBuf,
}

/// Options of `fogmap`.
#[derive(Args)]
pub struct FogmapArgs {
    /// A PNG of 8 or 16 bits, linear, white is 1, the first row at the smallest z.
    #[arg(required_unless_present = "export", conflicts_with = "export")]
    pub image: Option<PathBuf>,
    /// A scene and one of its terms, by id or place, whose map is written as a PNG of 16 bits.
    #[arg(long, num_args = 2, value_names = ["SCENE", "TERM"], requires = "out")]
    pub export: Option<Vec<String>>,
    /// Where to write it; `-` is standard output.
    #[arg(short, long, env = "FOGBANK_OUT", value_name = "FILE")]
    pub out: Option<PathBuf>,
}

/// Options of `serve`.
#[derive(Args, Clone, Debug)]
pub struct ServeArgs {
    /// Address and port; port 0 picks a free one.
    #[arg(
        long,
        env = "FOGBANK_LISTEN",
        default_value = "127.0.0.1:8080",
        value_name = "ADDR:PORT"
    )]
    pub listen: String,
    /// What renders.
    #[arg(long, env = "FOGBANK_BACKEND", value_enum, default_value_t)]
    pub backend: Backend,
    /// Directory that scenes are stored in; it is made if missing. Without it they are kept in memory and end with the
    /// server.
    #[arg(long, env = "FOGBANK_DATA_DIR", value_name = "DIR")]
    pub data_dir: Option<PathBuf>,
    /// A further name that clients may call the server by, besides localhost and addresses; may be repeated.
    #[arg(long, env = "FOGBANK_ALLOW_HOST", value_name = "NAME", value_delimiter = ',')]
    pub allow_host: Vec<String>,
    /// Requests that may wait while one is rendered, short and long ones each; one more is answered with 503.
    #[arg(long, env = "FOGBANK_QUEUE", default_value_t = 8, value_name = "N", value_parser = queue)]
    pub queue: usize,
    /// Seconds for an answer, waiting included; then 504.
    #[arg(long, env = "FOGBANK_DEADLINE_S", default_value_t = 30.0, value_name = "S",
        value_parser = seconds)]
    pub deadline_s: f64,
    /// The same for `reference`, as a scene's airlight or a side of a comparison.
    #[arg(long, env = "FOGBANK_REFERENCE_DEADLINE_S", default_value_t = 300.0, value_name = "S",
        value_parser = seconds)]
    pub reference_deadline_s: f64,
    /// Seconds that requests have to end once the server is asked to stop; then 503 [default: the deadline].
    #[arg(long, env = "FOGBANK_DRAIN_S", value_name = "S", value_parser = seconds)]
    pub drain_s: Option<f64>,
}

/// What renders.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Backend {
    /// A GPU made for it, else the processor.
    #[default]
    Auto,
    /// The processor.
    Cpu,
    /// A GPU, be it one in software.
    Gpu,
}

impl From<Backend> for fogbank_core::Backend {
    fn from(backend: Backend) -> Self {
        match backend {
            Backend::Auto => Self::Auto,
            Backend::Cpu => Self::Cpu,
            Backend::Gpu => Self::Gpu,
        }
    }
}

/// Options of `render`.
#[derive(Args)]
pub struct RenderArgs {
    /// A scene file, `-` for standard input, or `preset:NAME`.
    pub scene: String,
    /// What renders.
    #[arg(long, env = "FOGBANK_BACKEND", value_enum, default_value_t)]
    pub backend: Backend,
    /// Where to write; the ending says the format: .png .jpg .jpeg .webp .exr .npy; `-` is
    /// standard output and needs --format.
    #[arg(short, long, env = "FOGBANK_OUT", value_name = "FILE", requires_if("-", "format"))]
    pub out: PathBuf,
    /// The format, whatever the ending says.
    #[arg(long, env = "FOGBANK_FORMAT", value_parser = format_names())]
    pub format: Option<Format>,
    /// Pixels along a row.
    #[arg(long, env = "FOGBANK_WIDTH", default_value_t = 960)]
    pub width: u32,
    /// Rows of pixels.
    #[arg(long, env = "FOGBANK_HEIGHT", default_value_t = 540)]
    pub height: u32,
    /// How much work the picture may cost.
    #[arg(long, env = "FOGBANK_QUALITY", default_value = "full", value_parser = words::<Quality>())]
    pub quality: Quality,
    /// Which image of the frame.
    #[arg(long, env = "FOGBANK_LAYER", default_value = "beauty", value_parser = words::<Layer>())]
    pub layer: Layer,
    /// The airlight estimator, instead of the scene's own.
    #[arg(long, env = "FOGBANK_AIRLIGHT", value_parser = words::<Airlight>())]
    pub airlight: Option<Airlight>,
    /// Time of the picture, instead of the scene's own [s].
    #[arg(long, env = "FOGBANK_TIME", value_name = "S", allow_negative_numbers = true)]
    pub time: Option<f64>,
    /// Samples per pixel along edges [default: 1 in float formats and drafts, else 4].
    #[arg(long, env = "FOGBANK_SAMPLES", value_name = "N")]
    pub samples: Option<u32>,
    /// Exposure of 8-bit pictures [stops].
    #[arg(
        long,
        env = "FOGBANK_EXPOSURE_EV",
        default_value_t = 0.0,
        value_name = "EV",
        allow_negative_numbers = true
    )]
    pub exposure_ev: f64,
    /// How radiance is brought onto a screen.
    #[arg(long, env = "FOGBANK_TONEMAP", default_value = "agx", value_parser = words::<Tonemap>())]
    pub tonemap: Tonemap,
    /// Relative error of the mean optical depth that blobs far away may be left out for.
    #[arg(long, env = "FOGBANK_LOD_ERROR", default_value_t = 0.0, value_name = "SHARE")]
    pub lod_error: f64,
    /// Transmittance below which a ray ends.
    #[arg(long, env = "FOGBANK_FAR_CUT", default_value_t = 0.0, value_name = "SHARE")]
    pub far_cut: f64,
    /// Fraction of the picture that fog is computed for.
    #[arg(long, env = "FOGBANK_FOG_SCALE", default_value_t = 1.0, value_name = "SHARE")]
    pub fog_scale: f64,
    /// Whether what meshes lose of their light is computed at their corners.
    #[arg(long, env = "FOGBANK_PER_VERTEX")]
    pub per_vertex: bool,
    /// Seconds it may take [default: any].
    #[arg(long, env = "FOGBANK_DEADLINE_S", value_name = "S", value_parser = seconds)]
    pub deadline_s: Option<f64>,
}

/// Options of `probe`.
#[derive(Args)]
pub struct ProbeArgs {
    /// A scene file, `-` for standard input, or `preset:NAME`.
    pub scene: String,
    /// Where the ray starts [m].
    #[arg(long, env = "FOGBANK_ORIGIN", value_name = "X,Y,Z", value_parser = vec3,
        allow_hyphen_values = true)]
    pub origin: Vec3,
    /// Where it goes; any length but zero.
    #[arg(long, env = "FOGBANK_DIRECTION", value_name = "X,Y,Z", value_parser = vec3,
        allow_hyphen_values = true)]
    pub direction: Vec3,
    /// Where it ends at the latest [m]; without it, `far_m` of the scene.
    #[arg(long, env = "FOGBANK_MAX_DISTANCE", value_name = "M", allow_negative_numbers = true)]
    pub max_distance: Option<f64>,
}

/// Options of `compare`.
#[derive(Args)]
pub struct CompareArgs {
    /// A scene file, `-` for standard input, or `preset:NAME`.
    pub scene: String,
    /// What renders.
    #[arg(long, env = "FOGBANK_BACKEND", value_enum, default_value_t)]
    pub backend: Backend,
    /// Pixels along a row.
    #[arg(long, env = "FOGBANK_WIDTH", default_value_t = 320)]
    pub width: u32,
    /// Rows of pixels.
    #[arg(long, env = "FOGBANK_HEIGHT", default_value_t = 180)]
    pub height: u32,
    /// What is judged.
    #[arg(long, env = "FOGBANK_A", default_value = "auto",
        value_parser = words::<ComparedAirlight>())]
    pub a: ComparedAirlight,
    /// What it is judged by.
    #[arg(long, env = "FOGBANK_B", default_value = "reference",
        value_parser = words::<ComparedAirlight>())]
    pub b: ComparedAirlight,
    /// Steps of a, for march.
    #[arg(long, env = "FOGBANK_A_STEPS", value_name = "N")]
    pub a_steps: Option<u32>,
    /// Steps of b, for march.
    #[arg(long, env = "FOGBANK_B_STEPS", value_name = "N")]
    pub b_steps: Option<u32>,
    /// Where to write an image of the errors; the ending says the format, as in `render`.
    #[arg(short, long, env = "FOGBANK_OUT", value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Seconds it may take [default: any].
    #[arg(long, env = "FOGBANK_DEADLINE_S", value_name = "S", value_parser = seconds)]
    pub deadline_s: Option<f64>,
}

/// A picture to write: where, and in which format.
#[derive(Clone, Debug)]
pub struct Output {
    /// Where; `-` is standard output.
    pub path: PathBuf,
    /// In which format.
    pub format: Format,
}

impl Output {
    /// The format is the one asked for, else the one that the ending names.
    ///
    /// # Errors
    /// When there is no such ending.
    pub fn new(path: PathBuf, format: Option<Format>) -> Result<Self, String> {
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        let named = Format::ALL.into_iter().find(|f| f.extensions().contains(&ending.as_str()));
        let format = format.or(named).ok_or_else(|| {
            let known: Vec<_> = Format::ALL.iter().flat_map(|f| f.extensions()).copied().collect();
            format!("the ending must be one of {}", known.join(", "))
        })?;
        Ok(Self { path, format })
    }

    /// Whether it goes to standard output.
    pub fn is_standard(&self) -> bool {
        self.path == Path::new("-")
    }

    /// Finds out before anything is rendered whether the file can be written; leaves none behind.
    ///
    /// # Errors
    /// Why it cannot.
    pub fn check(&self) -> io::Result<()> {
        if self.is_standard() {
            return Ok(());
        }
        match OpenOptions::new().write(true).create_new(true).open(&self.path) {
            Ok(_) => std::fs::remove_file(&self.path),
            // What is no file, a pipe perhaps, would notice being opened.
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                let there = std::fs::metadata(&self.path)?;
                if there.is_file() || there.is_dir() {
                    OpenOptions::new().write(true).open(&self.path)?;
                }
                Ok(())
            }
            Err(error) => Err(error),
        }
    }
}

/// Formats by the endings of their files.
fn format_names() -> impl TypedValueParser<Value = Format> {
    let names = Format::ALL.iter().flat_map(|format| format.extensions());
    PossibleValuesParser::new(names).try_map(|name| {
        let format = Format::ALL.into_iter().find(|f| f.extensions().contains(&name.as_str()));
        format.ok_or("no such format")
    })
}

/// The words that the API has for a choice, with what they mean there.
fn words<T>() -> impl TypedValueParser<Value = T>
where
    T: DeserializeOwned + JsonSchema + Clone + Send + Sync + 'static,
{
    let schema = schema_for!(T);
    let choices = schema.get("oneOf").and_then(Value::as_array).into_iter().flatten();
    let value = |choice: &Value| {
        // Made once while the program runs.
        let word: &'static str = choice["const"].as_str()?.to_owned().leak();
        let meaning = choice["description"].as_str().unwrap_or_default().to_owned();
        Some(PossibleValue::new(word).help(meaning))
    };
    let values: Vec<_> = choices.filter_map(value).collect();
    PossibleValuesParser::new(values).try_map(|word| serde_json::from_value::<T>(word.into()))
}

fn vec3(text: &str) -> Result<Vec3, String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    let numbers: Option<[f64; 3]> = numbers.ok().and_then(|list| list.try_into().ok());
    numbers.map(Vec3).ok_or_else(|| "three numbers are needed: x,y,z".into())
}

fn seconds(text: &str) -> Result<f64, String> {
    let seconds: f64 = text.parse().map_err(|_| "a number of seconds is needed")?;
    if (1e-3..=86_400.0).contains(&seconds) { Ok(seconds) } else { Err("0.001 to 86400".into()) }
}

fn queue(text: &str) -> Result<usize, String> {
    let places = text.parse().ok().filter(|places| (1..=1024).contains(places));
    places.ok_or_else(|| "1 to 1024".into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definition_is_sound() {
        Cli::command().debug_assert();
    }

    fn render(arguments: &[&str]) -> Result<RenderArgs, clap::Error> {
        let all = [&["fogbank", "render", "-", "-o", "a.png"], arguments].concat();
        match Cli::try_parse_from(all)?.command {
            Some(Command::Render(args)) => Ok(args),
            _ => panic!("it is render"),
        }
    }

    #[test]
    fn the_words_of_the_api_are_taken() {
        let args = render(&["--layer=optical_depth", "--airlight=sun2005"]).unwrap();
        assert_eq!((args.layer, args.airlight), (Layer::OpticalDepth, Some(Airlight::Sun2005)));
        let Err(error) = render(&["--layer=fog"]) else { panic!("there is no such layer") };
        assert!(error.to_string().contains("optical_depth"));
    }

    #[test]
    fn options_without_a_command_are_those_of_serve() {
        let cli = Cli::try_parse_from(["fogbank", "--queue=3"]).unwrap();
        assert!(cli.command.is_none());
        assert_eq!(cli.serve.queue, 3);
    }

    #[test]
    fn triples_may_be_negative() {
        assert_eq!(vec3("-1,2.5, 3e2"), Ok(Vec3([-1.0, 2.5, 300.0])));
        assert!(vec3("1,2").is_err());
        let args = ["fogbank", "probe", "-", "--origin", "-1,2,3", "--direction", "0,0,-1"];
        assert!(Cli::try_parse_from(args).is_ok());
    }

    #[test]
    fn the_ending_says_the_format() {
        let output = |path: &str, format| Output::new(path.into(), format);
        assert_eq!(output("a/b.JPEG", None).unwrap().format, Format::Jpeg);
        assert_eq!(output("a.png", Some(Format::Exr)).unwrap().format, Format::Exr);
        assert!(output("a.gif", None).unwrap_err().contains("png, jpg"));
    }
}
