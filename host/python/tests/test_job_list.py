"""The command line's job list: what each line asks for is what the batch does."""

import subprocess

import skyfront
from astropy.io import fits


def test_jobs_of_the_list_give_what_the_batch_gives(program, tmp_path):
    for folder, seed in [("a", 1), ("b", 2)]:
        (tmp_path / folder).mkdir()
        fits.PrimaryHDU(skyfront.simulate("noisy", seed=seed, shape=(60, 70))[0]).writeto(tmp_path / folder / "x.fits")
    images = ["a/x.fits", "b/x.fits"]

    def run(*line, code=0):
        done = subprocess.run([program, "segment", *line], cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == code, done.stderr
        return done.stdout + done.stderr

    run(*images, "--out", "jobs", "--job-list", "jobs.csv")
    lines = [line.split(",") for line in (tmp_path / "jobs.csv").read_text().splitlines()]
    assert [image for image, _ in lines] == images and not (tmp_path / "jobs").exists()
    assert run(*images, "--out", "jobs", "--job-list", "-") == (tmp_path / "jobs.csv").read_text()
    assert "--overwrite" in run(*images, "--out", "jobs", "--job-list", "jobs.csv", code=1)
    run(*images, "--out", "batch", "--quiet")
    for image, folder in lines:
        run(image, "--out", folder, "--quiet")
        name = folder.split("/")[1]
        for file in ["segmentation.fits", "catalog.csv"]:
            assert (tmp_path / folder / file).read_bytes() == (tmp_path / "batch" / name / file).read_bytes()
    (tmp_path / "a,b.fits").write_bytes(b"")
    assert "comma" in run("a,b.fits", "--out", "jobs", "--job-list", "-", code=1)
