"""The lab's verdicts, messages and modules against the command-line compiler's own."""

import os
import random
import re
import subprocess
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from benchmarks.trees import SUFFIX, mutant, own_shaders
from shaderlab.compiler import Shaders, Source
from shaderlab.compiler.compile import compile_program
from shaderlab.compiler.diagnostics import check_version
from shaderlab.compiler.glslang import GLSLANG_WHEEL, find, link

VERTEX = """#version 330 core
layout (location = 0) in vec3 aPos;
layout (location = 1) in vec3 aNormal;
layout (location = 2) in vec2 aTexCoords;
out vec3 FragPos;
out vec3 Normal;
out vec2 TexCoords;
uniform mat4 model;
uniform mat4 view;
uniform mat4 projection;

void main()
{
    FragPos = vec3(model * vec4(aPos, 1.0));
    Normal = mat3(transpose(inverse(model))) * aNormal;
    TexCoords = aTexCoords;
    gl_Position = projection * view * vec4(FragPos, 1.0);
}
"""
FRAGMENT = """#version 330 core
out vec4 FragColor;
struct Light {
    vec3 position;
    vec3 diffuse;
    float constant;
    float linear;
};
in vec2 TexCoords;
in vec3 Normal;
in vec3 FragPos;
uniform vec3 viewPos;
uniform Light lights[2];
uniform sampler2D diffuseMap;

vec3 lit(Light light, vec3 normal)
{
    vec3 direction = normalize(light.position - FragPos);
    float diff = max(dot(normal, direction), 0.0);
    float reach = length(light.position - FragPos);
    return light.diffuse * diff / (light.constant + light.linear * reach);
}

void main()
{
    vec3 normal = normalize(Normal);
    vec3 result = vec3(0.0);
    for (int i = 0; i < 2; i++) {
        result += lit(lights[i], normal);
    }
    FragColor = vec4(result * texture(diffuseMap, TexCoords).rgb, 1.0);
}
"""
GEOMETRY = """#version 330 core
layout (points) in;
layout (line_strip, max_vertices = 2) out;
in vec3 tint[];
out vec3 shade;
void main() {
    shade = tint[0];
    gl_Position = gl_in[0].gl_Position; EmitVertex();
    gl_Position += vec4(0.1); EmitVertex();
    EndPrimitive();
}
"""
COMPUTE = """#version 430 core
layout (local_size_x = 64) in;
layout (std430, binding = 0) buffer Data { float values[]; };
void main() { values[gl_GlobalInvocationID.x] *= 2.0; }
"""
SHORT_VERTEX = """#version 330 core
in vec3 a;
out vec3 tint;
void main() { tint = a; gl_Position = vec4(a, 1.0); }
"""
SHORT_FRAGMENT = "#version 330 core\nin vec3 shade;\nout vec4 c;\nvoid main() { c = shade.rgbb; }\n"

PROGRAMS = [
    {"frag": FRAGMENT},
    {"vert": VERTEX},
    {"vert": VERTEX, "frag": FRAGMENT},
    {"vert": SHORT_VERTEX, "geom": GEOMETRY, "frag": SHORT_FRAGMENT},
    {"comp": COMPUTE},
]
MESSAGE = re.compile(r"^(?:ERROR|WARNING): 0:(\d+): (.*)$", re.M)
FLAGS = {"opengl": ["-G"], "vulkan": ["-V", "-R"]}
STAGES = {"vert": "vertex", "frag": "fragment", "geom": "geometry", "comp": "compute"}


def run_command(arguments: Sequence[str], folder: Path) -> str:
    library = find(GLSLANG_WHEEL, "libglslang.so").parent
    command = library.parent / "bin" / "glslangValidator"
    done = subprocess.run(
        [command, *arguments],
        cwd=folder,
        env={**os.environ, "LD_LIBRARY_PATH": str(library)},
        capture_output=True,
        check=False,
        timeout=60,
    )
    assert done.returncode >= 0, f"the command died of signal {-done.returncode}"
    return done.stdout.decode("utf-8", "replace")


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory, repository: Path) -> list[Source]:
    """The lab's own shaders and mutants of them and of the two above, as files in one folder."""
    folder = tmp_path_factory.mktemp("tree")
    rng = random.Random(3)
    texts = [(source.stage, source.text) for source in own_shaders(repository)]
    originals = [(source.stage, source.code) for source in own_shaders(repository)]
    originals += [("vertex", VERTEX), ("fragment", FRAGMENT), ("geometry", GEOMETRY)] * 8
    texts += [("fragment", FRAGMENT.replace("main", f"m{number}")) for number in range(5)]
    own = len(texts)
    while len(texts) < own + 200:
        stage, text = rng.choice(originals)
        texts.append((stage, mutant(text, rng)))
    texts += [("fragment", "void main() { gl_FragColor = vec4(1); }\n")]
    texts += [("fragment", "#version 330_core\nvoid main() {}\n")]
    sources = []
    for number, (stage, text) in enumerate(texts):
        path = folder / f"m{number:03}.{SUFFIX[stage]}"
        path.write_text(text, newline="")
        sources.append(Shaders([folder]).load(path.name))
    return sources


def test_plain_verdicts_and_messages_are_the_commands_own(tree: list[Source]) -> None:
    folder = Path(tree[0].path).parent
    printed = run_command(["-d", *(source.name for source in tree)], folder)
    theirs = dict(re.findall(r"^(m\d+\.\w+)\n(.*?)(?=^m\d+\.|\Z)", printed, re.M | re.S))
    assert len(theirs) == len(tree) > 300
    rejected = reworded = 0
    for source in tree:
        parsed = link([source], "glsl").parsed
        rejected += not parsed
        assert parsed is ("ERROR: " not in theirs[source.name]), source.name
        # Their messages are in the diagnostics, word for word, at their lines; the C interface
        # has other words for what the preprocessor does not know.
        verdict = compile_program([source], ["glsl"]).verdicts[0]
        said = {(d.line, " ".join(d.message.split())) for d in verdict.diagnostics}
        for line, message in MESSAGE.findall(theirs[source.name]):
            words = " ".join(message.split()).removeprefix("'' : ")
            if words != "compilation terminated":
                reworded += (source.place(int(line))[1], words) not in said
    assert 100 < rejected < len(tree) - 80
    assert reworded < len(tree) / 20


def test_linked_verdicts_and_modules_are_the_commands_own(
    tree: list[Source], tmp_path: Path
) -> None:
    """One process a file and target, since the command links all the files that it is given: for
    the texts that do not link, and one in eight of those that do. `benchmarks.verdicts` takes all.
    """
    accepted = [source for source in tree if link([source], "glsl").parsed]
    assert len(accepted) > 80
    linking = [source for source in accepted if link([source], "glsl").ok]
    accepted = [source for source in accepted if source not in linking] + linking[::8]

    def compare(number: int) -> tuple[int, int]:
        source = accepted[number]
        folder = tmp_path / str(number)
        folder.mkdir()
        linked = link([source], "glsl")
        made = 0
        for target, flags in FLAGS.items():
            if check_version(source, target):
                continue
            printed = run_command([*flags, "--aml", "--amb", source.path], folder)
            # Some texts are wrong for SPIR-V alone: two inputs at one location, for one.
            made_here = link([source], target)
            assert ("ERROR: " in printed) is (not made_here.ok), source.name
            assert linked.ok or not made_here.ok, source.name
            if linked.ok is made_here.ok:
                assert linked.log.strip() in printed, source.name
            ours = made_here.modules
            file = folder / f"{SUFFIX[source.stage]}.spv"
            theirs = {source.stage: file.read_bytes()} if file.exists() else {}
            assert ours == theirs, (source.name, target)
            made += len(theirs)
            file.unlink(missing_ok=True)
        return made, not linked.ok

    with ThreadPoolExecutor(2) as threads:
        counts = list(threads.map(compare, range(len(accepted))))
    assert sum(made for made, _ in counts) > 35
    assert sum(failed for _, failed in counts) >= 5


@pytest.mark.parametrize("target", ["opengl", "vulkan"])
@pytest.mark.parametrize("program", PROGRAMS, ids=lambda p: "+".join(p))
def test_modules_are_the_commands_own(tmp_path: Path, program: dict[str, str], target: str) -> None:
    sources = _sources(program, tmp_path)
    flags = ["-G"] if target == "opengl" else ["-V", "-R"]
    run_command([*flags, "--aml", "--amb", *(s.name for s in sources)], tmp_path)
    ours = link(sources, target).modules
    for extension in program:
        theirs = (tmp_path / f"{extension}.spv").read_bytes()
        assert ours[STAGES[extension]] == theirs, extension
    if len(program) == 1:
        assert compile_program(sources).spirv[target] == ours


def test_link_messages_are_the_commands_own(tmp_path: Path) -> None:
    wrong = [
        {"vert": VERTEX, "frag": FRAGMENT.replace("in vec3 Normal", "in vec4 Normal")},
        {"vert": VERTEX.replace("void main", "void mane")},
        {
            "frag": FRAGMENT.replace("void main", "vec3 f();\nvoid main").replace(
                "lit(l", "f() + lit(l"
            )
        },
        {"geom": "#version 330 core\nvoid main() {}\n"},
    ]
    for number, program in enumerate(wrong):
        folder = tmp_path / str(number)
        folder.mkdir()
        sources = _sources(program, folder)
        printed = run_command(["-d", "-l", *(s.name for s in sources)], folder)
        ours = link(sources, "glsl")
        assert not ours.ok, number
        assert ours.log.strip() in printed, number
        assert ours.log.strip() or any(ours.stage_logs.values()), number


def _sources(program: dict[str, str], folder: Path) -> list[Source]:
    for extension, text in program.items():
        (folder / f"p.{extension}").write_text(text)
    return [Shaders([folder]).load(f"p.{extension}") for extension in program]
