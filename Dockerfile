# The planner as a service: slim, not root, wheels only.
#   docker build -t kabo . && docker run --rm -p 127.0.0.1:7447:7447 kabo
#   kabo request domains/bartender/four_bottles.yaml --connect tcp/127.0.0.1:7447
FROM python:3.12-slim AS wheel
WORKDIR /source
COPY pyproject.toml README.md LICENSE ./
COPY kabo kabo
COPY domains domains
COPY meshes meshes
RUN pip wheel --no-cache-dir --no-deps --wheel-dir /wheels .

FROM python:3.12-slim
# pinocchio needs libgomp1, which slim images lack.
RUN apt-get update \
    && apt-get install --yes --no-install-recommends libgomp1 \
    && rm -rf /var/lib/apt/lists/*
# The C++ headers that come with pinocchio are half of what it installs, and nobody compiles here.
RUN --mount=type=bind,from=wheel,source=/wheels,target=/wheels \
    pip install --no-cache-dir --only-binary :all: /wheels/kabo-*.whl \
    && rm -rf /usr/local/lib/python3.12/site-packages/cmeel.prefix/include
RUN useradd --create-home kabo
USER kabo
WORKDIR /home/kabo
# Kernels are compiled now, for any processor of this architecture, so that the first request need not wait.
ENV KABO_CPU=generic KABO_CACHE=/home/kabo/.cache/kabo
RUN kabo generate force_sensing --n 1 -o warm.yaml \
    && kabo solve warm.yaml -o warm.json \
    && rm warm.yaml warm.json
EXPOSE 7447
CMD ["kabo", "serve", "--listen", "tcp/0.0.0.0:7447"]
