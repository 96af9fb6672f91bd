# The robot's runtime: camera, tracking, classification, ROS 2 without ROS. No torch, no compiler.
#
#     docker build -t circumspect .
#     docker run --rm --volume "$PWD:/data" circumspect classify chair.ply
#     docker run --rm --network host circumspect ros2 --driver realsense --odometry /odom

FROM python:3.11-slim-bookworm AS build
# hadolint ignore=DL3008
RUN apt-get update \
    && apt-get install --yes --no-install-recommends g++ \
    && rm -rf /var/lib/apt/lists/*
RUN python -m venv /opt/circumspect
WORKDIR /source
COPY CMakeLists.txt LICENSE README.md constraints.txt pyproject.toml ./
COPY native native
COPY src src
ENV PIP_CONSTRAINT=constraints.txt PIP_BUILD_CONSTRAINT=constraints.txt PIP_NO_CACHE_DIR=1
RUN /opt/circumspect/bin/python -m pip install pip \
    && /opt/circumspect/bin/python -m pip install ".[bags,ros2]"

FROM python:3.11-slim-bookworm
RUN useradd --create-home --uid 1000 robot && install --directory --owner=1000 /data
COPY --from=build /opt/circumspect /opt/circumspect
ENV PATH=/opt/circumspect/bin:$PATH PYTHONUNBUFFERED=1
USER 1000
WORKDIR /data
ENTRYPOINT ["circumspect"]
CMD ["--help"]
