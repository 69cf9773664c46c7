# shaderlab with all its drivers: docker build -t shaderlab . && docker run -v "$PWD:/work" shaderlab run .
FROM python:3.13-slim-bookworm
RUN apt-get update -qq \
    && apt-get install -y -qq --no-install-recommends \
        libegl1 libgl1 libgl1-mesa-dri \
        libvulkan1 mesa-vulkan-drivers vulkan-validationlayers chromium spirv-cross \
    && rm -rf /var/lib/apt/lists/*
COPY . /src
RUN pip install --no-cache-dir --constraint /src/constraints.txt \
        '/src[course,pytest,vulkan,webgl]' \
    && rm -rf /src
WORKDIR /work
ENTRYPOINT ["shaderlab"]
CMD ["doctor"]
